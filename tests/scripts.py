"""Python in a process of its own."""

from tests.processes import ROOT, run


def run_python(*arguments, timeout=500, cwd=ROOT, **environment):
    """Run Python on this checkout: what it prints. It must end without an error."""
    return run(*arguments, timeout=timeout, cwd=cwd, variables=environment)[0].strip()
