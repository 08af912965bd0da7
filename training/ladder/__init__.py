"""The ladder: tasks of rising difficulty, algorithms that learn them from scratch, their curves.

Each rung is a file in `training/benchmarl_tasks/conf/task/swarm_forage`, each algorithm a file in
`training/ladder/algorithms`; a new file adds one.
"""
