"""The compiler: what machine code is kept for, and when it is made anew."""

import json
import os
import sys
from types import ModuleType

import numba
import numpy as np
import pytest
from numba.core.runtime import rtsys
from numba.core.runtime._nrt_python import memsys_enable_stats
from numba.core.types import ExternalFunction, float64, intp, void
from numba.extending import intrinsic

from swarm_forage_env.compiler import _bound, bind, entry_point, kernel
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.fingerprint import fingerprint
from swarm_forage_env.kernel_cache import cache_folder
from swarm_forage_env.record import one_record
from tests.processes import run

compiled = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")

CALLEE = """
SCALE = 3.0
TABLE = np.array([1.0, 2.0])
LIMITS = (0.0, 9.0)

@kernel
def scaled(x):
    '''Scaled.'''
    return min(SCALE * x + TABLE[0], LIMITS[1])
"""

CALLER = """
@kernel
def halved(x):
    return 0.5 * scaled(x)

@entry_point
def total(numbers):
    '''Sum of what is halved.'''
    found = 0.0
    for k in range(numbers.shape[0]):
        found += halved(numbers[k])
    return found
"""


def module(text, **names):
    """A module of this text, in which these names are imported."""
    made = ModuleType("made")
    vars(made).update({"np": np, "kernel": kernel, "entry_point": entry_point, **names})
    exec(compile(text, "made.py", "exec"), vars(made))
    return made


def key(callee=CALLEE, caller=CALLER):
    """The fingerprint of the caller's entry point."""
    return fingerprint(module(caller, scaled=module(callee).scaled).total)


SAME = {
    "a comment": (CALLEE.replace("    return min", "    # scaled\n    return min"), CALLER),
    "a blank line": ("\n\n" + CALLEE, CALLER.replace("    for", "\n    for")),
    "a docstring of the callee": (CALLEE.replace("Scaled.", "Three times."), CALLER),
    "a docstring of the caller": (CALLEE, CALLER.replace("Sum of", "The sum of")),
    "a function that is not called": (CALLEE + "\n@kernel\ndef other(x):\n    return x\n", CALLER),
}

OTHER = {
    "a parameter": (CALLEE.replace("(x)", "(y)").replace(" x ", " y "), CALLER),
    "a line of the caller": (CALLEE, CALLER.replace("found +=", "found -=")),
    "the kind of a global array": (CALLEE.replace("2.0])", "2.0], np.float32)"), CALLER),
    "a global tuple of the callee": (CALLEE.replace("9.0)", "8.0)"), CALLER),
}


@compiled
@pytest.mark.parametrize("what", SAME | OTHER)
def test_the_fingerprint_changes_with_the_code_and_not_with_its_comments(what):
    texts = (SAME | OTHER)[what]
    assert texts != (CALLEE, CALLER)
    assert (key(*texts) == key()) == (what in SAME)


@compiled
def test_the_fingerprint_tells_kernels_apart_that_call_each_other():
    text = """
@kernel
def even(n):
    return True if n == 0 else odd(n - 1)

@kernel
def odd(n):
    return False if n == 0 else even(n - 1)
"""
    made = module(text)
    assert fingerprint(made.even) != fingerprint(made.odd)
    assert fingerprint(made.even) == fingerprint(module(text).even)


@compiled
def test_the_fingerprint_knows_functions_of_a_library_by_name_and_arguments():
    text = "@kernel\ndef go(x):\n    step(x)\n"
    named = ("step", float64), ("stride", float64), ("step", intp), ("step", float64)
    functions = [ExternalFunction(name, void(kind)) for name, kind in named]
    *others, again = [fingerprint(module(text, step=each).go) for each in functions]
    assert (len({*others}), again) == (3, others[0])


@compiled
def test_the_fingerprint_changes_with_the_instructions_of_an_intrinsic():
    text = """
@intrinsic
def step(_, x):
    return x(x), lambda context, builder, _, values: builder.fadd(*values, *values)

@kernel
def go(x):
    return step(x)
"""
    texts = text, text, text.replace("fadd", "fmul")
    one, same, other = (fingerprint(module(each, intrinsic=intrinsic).go) for each in texts)
    assert one == same != other


NUMBERS = """
import enum

SHARE = 0.5
BY = 0.1
TABLE = np.array([1.0, 2.0])

class Area(enum.IntEnum):
    NEST = 0
    PREY = 1

@kernel
def scaled(x):
    return 3.0 * x
"""

SHARE = "SHARE = 0.5", "SHARE = 0.25"
TABLE = "[1.0, 2.0]", "[1.0 + 1e-12, 2.0]"
SCALED = "3.0 * x", "4.0 * x"
PREY = "PREY = 1", "PREY = 2"

READERS = {
    "a number of a module": ("numbers.SHARE * x", SHARE),
    "an array of a module": ("numbers.TABLE[0] * x", TABLE),
    "a function of a module": ("numbers.scaled(x)", SCALED),
    "a member of an enumeration": ("x + (5.0 if Area.PREY == 1 else 6.0)", PREY),
    "an array in a tuple": ("PAIR[1][0] * x", TABLE),
    "a number around the function": ("around * x", SHARE),
    "an array around the function": ("table[0] * x", TABLE),
    "a function around the function": ("called(x)", SCALED),
    "a default": ("by * x", ("BY = 0.1", "BY = 0.2")),
    "what a function within reads": ("(lambda y: SHARE * y)(x)", SHARE),
}
"""How an entry point reads something of a module, and what is edited there."""


def reader(read, numbers):
    """An entry point that reads something of a module in this way, and its fingerprint."""
    text = f"""
PAIR = 1.0, numbers.TABLE
Area = numbers.Area
SHARE = numbers.SHARE

def made(around, table, called):
    @kernel
    def read(x, by=numbers.BY):
        return {read}

    @entry_point
    def total(x):
        return read(x)

    return total

total = made(numbers.SHARE, numbers.TABLE, numbers.scaled)
"""
    total = module(text, numbers=numbers).total
    return total, fingerprint(total)


@compiled
@pytest.mark.parametrize(("read", "edit"), READERS.values(), ids=READERS)
def test_the_fingerprint_knows(read, edit):
    kept, key = reader(read, module(NUMBERS))
    other, other_key = reader(read, module(NUMBERS.replace(*edit)))
    assert kept(2.0) != other(2.0)
    assert key != other_key
    assert key == reader(read, module(NUMBERS))[1]


@pytest.fixture
def fresh_cache(tmp_path, monkeypatch):
    """A folder for machine code in which there is none yet, and nothing is kept in memory."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    _bound.cache_clear()
    return cache_folder()


def apply(numbers):
    """A template: the free name is what is done with each number."""
    for k in range(numbers.shape[0]):
        numbers[k] = change(numbers[k], k)


@kernel
def double(x, k):
    return 2.0 * x


@kernel
def negate(x, k):
    return -x


@kernel
def add(x, k):
    return x + k


def applied(change):
    numbers = np.array([1.0, 2.0, 3.0])
    bind(apply, {"change": change})(numbers)
    return numbers.tolist()


@compiled
def test_the_same_composition_shares_its_machine_code_on_disk(fresh_cache):
    made = []
    for change in (double, double, add):
        _bound.cache_clear()
        made.append(bind(apply, {"change": change}))
        made[-1](np.ones(3))
    first, again, other = made
    assert not sum(first.stats.cache_hits.values())
    assert sum(again.stats.cache_hits.values()) == 1
    assert not sum(again.stats.cache_misses.values())
    assert not sum(other.stats.cache_hits.values())
    assert len({*fresh_cache.glob("*.nbi")}) == 2


@compiled
def test_a_bound_template_is_compiled_once_keeps_its_name_and_runs_without_the_interpreters_lock():
    bound = bind(apply, {"change": double, "not named": add})
    assert bind(apply, {"change": double}) is bound
    assert (bound.__name__, bound.__doc__) == ("apply", apply.__doc__)
    assert "change" not in globals()
    for each in (bound, double, entry_point(double)):
        assert each.targetoptions["nogil"]


MAKERS = {
    "makes one": "np.full(9, table[k, 0])[1]",
    "makes a list": "[table[k, 0]][0]",
    "is handed one": "fresh(table[k, 0])[0]",
    "is handed a part of one": "row(table, k)[0]",
    "is handed two that it made": "pair(fresh(table[k, 0]), table)[0][0]",
    "is handed one by a function of numba's": "zeros()[0] + table[k, 0]",
}

HANDED = """
@kernel
def first(row):
    return row[0]

@kernel
def row(table, k):
    return table[k]

@kernel
def pair(a, b):
    return a, b

@kernel
def fresh(x):
    return np.full(9, x)

@numba.njit
def zeros():
    return np.zeros(9)

@kernel
def part(table, k):
    return {}

@entry_point
def total(table):
    found = 0.0
    for k in range(table.shape[0]):
        found += part(table, k)
    return found
"""


@compiled
@pytest.mark.parametrize("what", MAKERS.values(), ids=MAKERS)
def test_arrays_live_as_long_as_they_are_held_where_a_part(what, fresh_cache):
    total = module(HANDED.format(what), numba=numba).total
    table = np.arange(8.0).reshape(4, 2)
    assert total(table) == 12.0
    memsys_enable_stats()
    before, holders = rtsys.get_allocation_stats(), sys.getrefcount(table)
    assert [total(table) for _ in range(10)] == [12.0] * 10
    after = rtsys.get_allocation_stats()
    assert after.alloc - before.alloc == after.free - before.free
    assert sys.getrefcount(table) == holders


@compiled
def test_a_kernel_that_makes_no_array_does_not_count_who_holds_one(fresh_cache):
    total = module(HANDED.format("first(table[k])"), numba=numba).total
    total(np.ones((4, 2)))
    (text,) = total.inspect_llvm().values()
    assert "NRT_incref" not in text


@compiled
def test_a_field_that_a_record_lacks_is_told_with_the_kernel_that_reads_it():
    made = module(CALLEE.replace("SCALE * x", "x.scal") + CALLER)
    with pytest.raises(ConfigError, match=r"kernel made\.scaled: reads 'scal', no field"):
        made.total(one_record({"scale": 1.0}))
    made = module(CALLEE.replace("(x)", "(x, y)") + CALLER)
    with pytest.raises(ConfigError, match=r"scaled: is called with 1 arguments: missing .* 'y'"):
        made.total(np.ones(1))
    with pytest.raises(ConfigError, match=r"run: the tick calls it as 'change', but .* decorate"):
        bind(apply, {"change": run})


@compiled
def test_a_kernel_that_kernels_alone_call_is_compiled_for_python_when_python_calls_it(fresh_cache):
    made = module(CALLEE + CALLER)
    assert made.total(np.arange(3.0)) == 6.0
    signature = (float64,)
    assert callable(made.scaled.overloads[signature].entry_point) is False
    assert made.scaled(2.0) == 7.0, "Python calls what a kernel has called"
    assert callable(made.scaled.overloads[signature].entry_point)
    again = module(CALLER.replace("0.5", "0.25"), scaled=made.scaled)
    assert again.total(np.arange(3.0)) == 3.0, "a kernel calls what Python has called"


@compiled
def test_a_cache_that_cannot_be_written_keeps_nobody_from_working(tmp_path, monkeypatch, capsys):
    (tmp_path / "swarm-forage").write_text("a file where the folder should be")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    for change, expected in ((double, [2.0, 4.0, 6.0]), (negate, [-1.0, -2.0, -3.0])):
        _bound.cache_clear()
        assert applied(change) == expected
    warned = [
        line for line in capsys.readouterr().err.splitlines() if "every process compiles" in line
    ]
    assert len(warned) == 1, "once for all kernels"
    assert f"{cache_folder()} cannot be written (" in warned[0]


@compiled
@pytest.mark.parametrize("mode", [0o777, 0o770])
def test_a_cache_that_others_may_write_is_neither_read_nor_written(fresh_cache, capsys, mode):
    assert applied(double) == [2.0, 4.0, 6.0]
    assert fresh_cache.stat().st_mode & 0o777 == 0o700
    fresh_cache.chmod(mode)
    before = sorted(fresh_cache.iterdir())
    _bound.cache_clear()
    again = bind(apply, {"change": double})
    again(np.ones(3))
    assert applied(negate) == [-1.0, -2.0, -3.0]
    assert not sum(again.stats.cache_hits.values())
    assert sorted(fresh_cache.iterdir()) == before
    assert f"{fresh_cache}: others may write there" in capsys.readouterr().err


def flip(content):
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


def cut(content):
    return content[: len(content) // 2]


@compiled
@pytest.mark.parametrize("damage", [cut, flip, lambda content: b""])
@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_a_damaged_file_of_the_cache_is_replaced(fresh_cache, ending, damage):
    hits = []
    for moment in ("compiled", "damaged", "kept"):
        _bound.cache_clear()
        made = bind(apply, {"change": double})
        numbers = np.array([1.0, 2.0, 3.0])
        made(numbers)
        assert numbers.tolist() == [2.0, 4.0, 6.0]
        hits.append(sum(made.stats.cache_hits.values()))
        if moment == "compiled":
            (file,) = fresh_cache.glob(f"*.{ending}")
            file.write_bytes(damage(file.read_bytes()))
    assert hits == [0, 0, 1]


# --- other processes -----------------------------------------------------------------------------


def run_with(cache, script, *arguments, **variables):
    """What a process prints as JSON, and what it says to the user."""
    variables["XDG_CACHE_HOME"] = str(cache)
    stdout, stderr = run("-c", script, *arguments, variables=variables)
    return json.loads(stdout), stderr


SWARM = """
import gc, json
import baselines.controllers
import swarm_forage_env.foraging.named
import swarm_forage_env.foraging.task
from numba.core.dispatcher import Dispatcher
from swarm_forage_env.kernel_cache import cache_folder
from swarm_forage_env.loop import Loop
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario

loop = Loop(find_scenario("es1"), CONTROLLERS["dsgiff"], [5], "rigid")
for _ in range(20):
    loop.step()
made = [each for each in gc.get_objects() if isinstance(each, Dispatcher)]
kept = [each for each in made if type(each._cache).__name__ == "_LateCache" and each.signatures]
print(json.dumps({
    "files": {file.name: file.stat().st_mtime_ns for file in cache_folder().iterdir()},
    "misses": sum(sum(each.stats.cache_misses.values()) for each in kept),
    "hits": sum(sum(each.stats.cache_hits.values()) for each in kept),
    "compiled": sorted(
        each.__name__ for each in made
        if each not in kept and each.signatures and each._compiling_counter.counter == 0
    ),
    "pose": loop.world.robots["pose"].tobytes().hex(),
}))
"""


@compiled
def test_a_second_process_compiles_nothing(tmp_path):
    first, said = run_with(tmp_path, SWARM)
    assert "compiling the simulation, once" in said
    assert first["misses"] >= 4
    second, said = run_with(tmp_path, SWARM)
    assert not said
    assert second["misses"] == 0
    assert second["hits"] == first["misses"]
    assert second["compiled"] == []
    assert second["files"] == first["files"]
    assert second["pose"] == first["pose"]


EDITED = """
import json, sys
import numpy as np

sys.path.insert(0, sys.argv[1])
from caller import total
from swarm_forage_env.kernel_cache import cache_folder
print(json.dumps([total(np.ones(2)), sum(total.stats.cache_hits.values())]))
"""


def outcome(folder):
    """What `total` of the module `caller` gives, and how much of it was kept."""
    return run_with(folder / "cache", EDITED, folder, PYTHONDONTWRITEBYTECODE="1")[0]


@compiled
def test_a_callee_edited_in_another_file_is_compiled_anew(tmp_path):
    head = "import numpy as np\nfrom swarm_forage_env.compiler import entry_point, kernel\n"
    (tmp_path / "caller.py").write_text(head + "from callee import scaled\n" + CALLER)

    def result(callee):
        (tmp_path / "callee.py").write_text(head + callee)
        return outcome(tmp_path)

    assert result(CALLEE) == [4.0, 0]
    assert result("# a comment\n" + CALLEE) == [4.0, 1]
    assert result(CALLEE.replace("SCALE = 3.0", "SCALE = 4.0")) == [5.0, 0]


RULE = """
from swarm_forage_env.compiler import kernel

@kernel
def change(x, k):
    return x + k
"""

TEMPLATE = """
def apply(numbers):
    numbers[1] = change(numbers[1], 1)
    return numbers[1]
"""


@compiled
def test_a_rule_whose_module_has_another_name_now_is_compiled_anew(tmp_path):
    head = "from swarm_forage_env.compiler import bind\nfrom template import apply\n"
    (tmp_path / "template.py").write_text(TEMPLATE)
    results = []
    for old, name in ((None, "before"), ("before", "after"), (None, "after")):
        if old:
            (tmp_path / f"{old}.py").unlink()
        (tmp_path / f"{name}.py").write_text(RULE)
        bound = f"import {name}\ntotal = bind(apply, {{'change': {name}.change}})\n"
        (tmp_path / "caller.py").write_text(head + bound)
        results.append(outcome(tmp_path))
    assert results == [[2.0, 0], [2.0, 0], [2.0, 1]]


@compiled
@pytest.mark.parametrize("command", [["list"], ["list", "mg1-hexagon"], ["evaluate", "--help"]])
def test_what_runs_no_world_compiles_nothing(tmp_path, command):
    variables = {"XDG_CACHE_HOME": str(tmp_path)}
    assert run("-m", "swarm_forage_env", *command, variables=variables)[1] == ""
    assert not list(tmp_path.rglob("*.nbi"))


FORKS = """
import os, signal, threading, time
import numba
import numpy as np
from numba.core import event
from swarm_forage_env import parallel_env

begun, env = threading.Event(), parallel_env("es1", n_robots=2, physics="kinematic")

class Amid(event.Listener):
    def on_start(self, _):
        if not begun.is_set():
            begun.set()
            time.sleep(1.0)

    def on_end(self, _):
        pass

event.register("numba:compile", Amid())
thread = threading.Thread(target=numba.njit(lambda x: x + 1), args=(1,))
thread.start()
assert begun.wait(60.0)
child = os.fork()
if child == 0:
    signal.alarm(200)
    env.reset(seed=0)
    env.step(dict.fromkeys(env.agents, np.zeros(2)))
    os._exit(7)
thread.join()
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
"""


@compiled
def test_a_process_forked_while_a_thread_compiles_can_compile_and_step():
    run("-c", FORKS)


NAMES = """
import os
import numpy as np
from swarm_forage_env.compiler import entry_point

@entry_point
def total(rows):
    return rows["x"].sum()

def names(size):
    total(np.zeros(1, [("x", float, size)]).view(np.recarray))
    for each in total.overloads.values():
        yield from (f.name for f in each.library._final_module.functions if not f.is_declaration)

print(*names(3), flush=True)
if os.fork() == 0:
    print(*names(4), flush=True)
    os._exit(0)
os.wait()
print(*names(5), flush=True)
"""


@compiled
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_names_of_functions_in_machine_code_are_of_one_process_alone(tmp_path):
    """Else one that is kept would be called in the place of another's, for other records."""
    found = []
    for folder in ("one", "other"):
        stdout, _ = run("-c", NAMES, variables={"XDG_CACHE_HOME": str(tmp_path / folder)})
        first, forked, later = (
            {name for name in line.split() if "total" in name} for line in stdout.splitlines()
        )
        found += [first, forked - first, later - first]
    assert all(found)
    for k, one in enumerate(found):
        for other in found[k + 1 :]:
            assert not one & other
