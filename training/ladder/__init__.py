"""The ladder: tasks of rising difficulty, algorithms that learn them from scratch, their curves.

A rung is a file of `training/benchmarl_tasks/conf/task/swarm_forage`, an algorithm one of
`training/ladder/algorithms`: another one is another file.
"""
