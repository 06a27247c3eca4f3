#!/usr/bin/python3
"""Usage: /usr/bin/python3 tests/mutants/run.py [--count 200] [--seed N] [--folders animate,enclose]
       [--at FILE:LINE …] [--only N,…] [--most SECONDS] [--flags …]

Changes the headers at random places and tells which changes no test notices, and which functions (of more
than one statement) no test calls. Not part of CI: 200 mutants take about 40 minutes of a processor.
Installs what it needs, on Debian 12.

One build holds all mutants of a run. In a copy of the headers `(cageform_mutant(17) ? (a <= b) : (a < b))`
stands for `a < b`; the environment says at run time which mutant is alive. What does not compile is dropped.
Each test program runs once without a mutant, which records the time of each test case and the mutants that it
reaches. Then each mutant of the program's folders runs against the cases that reach it, each a process, short
ones first, until one fails. Survivors run against the other programs' cases too. A case that takes more than
five times as long as without the mutant, and two seconds, has failed.

  --count    how many mutants are drawn from all places
  --seed     of the draw; it is printed, so that a run can be repeated
  --folders  of include/cageform; all unless told
  --at       all mutants of these lines as well, as in enclose/plane/cage_maker.hpp:190
  --only     of those drawn, only these numbers, as in 3,17
  --most     seconds of test cases in each program that a mutant passes before it counts as survived
  --flags    more for the compiler, as -fsanitize=address,undefined
"""
import argparse
import os
import random
import re
import resource
import subprocess
import sys
import time

from locations import EIGEN, HEADERS, ROOT, Finder, rewritten

WORK = ROOT / "build" / "mutants"
PACKAGES = "clang-19 python3-clang-19 libeigen3-dev libglm-dev nlohmann-json3-dev catch2".split()
PROGRAMS = {  # rooms that instantiate the same templates are one program
    "core": ["core", "adapt"],
    "animate": ["animate", "exchange"],
    "enclose": ["enclose"],
    "pose": ["pose", "skeleton"],
    "binding": ["binding", "clone"],
    "coordinates": ["coordinates", "grid", "fields", "averaging", "cage"],
}
CLANG = ["clang++-19", "-std=c++20", "-w"]


class Program:
    """A test program with the mutants that it is made with."""

    def __init__(self, name, size, flags):
        self.name, self.size, self.flags = name, size, flags
        self.path = WORK / name
        self.cases = []

    def compiler(self):
        return [*CLANG, "-O1", "-Wno-c++11-narrowing", "-ferror-limit=0", "-D_GLIBCXX_ASSERTIONS", "-pthread",
                "-DCATCH_CONFIG_EXTERNAL_INTERFACES", f'-DCAGEFORM_TEST_DATA="{ROOT}/tests/data"',
                f"-DCAGEFORM_MUTANTS={self.size}", "-include", str(ROOT / "tests/mutants/mutant.hpp"),
                "-I", str(WORK / "include"), "-I", str(ROOT / "tests"),
                "-I", str(ROOT / "examples/support"), *EIGEN, *self.flags]

    def build(self, headers, mutants):
        """Compiles all tests as one file until that goes, each time without the mutants at whose lines errors
        are. Returns those that are left."""
        files = [f for folder in PROGRAMS[self.name] for f in sorted((ROOT / "tests" / folder).glob("*.cpp"))]
        source = self.path.with_suffix(".cpp")
        source.write_text("".join(f'#include "{f}"\n' for f in [ROOT / "tests/mutants/recorder.hpp", *files]))
        while True:
            for path, text in headers.items():
                copy = copy_of(path)
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy.write_text(rewritten(text, [m for m in mutants if m.path == path]))
            run = subprocess.run([*self.compiler(), str(source), str(catch_main()), "-o", str(self.path)],
                                 capture_output=True, text=True)
            if run.returncode == 0:
                return mutants
            bad = culprits(run.stderr, mutants)
            if not bad:
                sys.exit(run.stderr)
            mutants = [m for m in mutants if m.number not in bad]

    def record(self):
        """Notes of each test case that passes its seconds, its name and what it reaches."""
        path = self.path.with_suffix(".record")
        path.unlink(missing_ok=True)
        subprocess.run([str(self.path)], env={**os.environ, "MUTANTS_RECORD": str(path)},
                       stdout=subprocess.DEVNULL)
        for line in path.read_text().splitlines():
            name, seconds, passed, reached = line.split("\t")
            if passed == "1":
                self.cases.append((float(seconds), name, {int(n) for n in reached.split()}))
        self.cases.sort(key=lambda case: case[:2])

    def fails(self, number, seconds, name):
        """How a test case notices a mutant; nothing where it passes."""
        limit = int(5 * seconds + 2)
        pattern = re.sub(r'([\\,\[\]"*])', r"\\\1", name)

        def limited():
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            if "sanitize" not in " ".join(self.flags):  # sanitizers take all addresses
                resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))

        try:
            run = subprocess.run([str(self.path), "--abort", pattern], preexec_fn=limited, capture_output=True,
                                 env={**os.environ, "MUTANT": str(number)}, timeout=20 * limit + 60)
        except subprocess.TimeoutExpired:
            return "out of time"
        code = run.returncode
        if b"No tests ran" in run.stdout:
            sys.exit(f"no test case is called {pattern}")
        return "out of time" if code in (-24, -9) else "crashed" if code < 0 else "failed" if code else ""

    def judge(self, mutant, most):
        """Returns the test that kills the mutant, if one does, and how many cases it passes."""
        spent, passed = 0.0, 0
        for seconds, name, reached in self.cases:
            if mutant.number not in reached or spent > most:
                continue
            how = self.fails(mutant.number, seconds, name)
            if how:
                return f"{how}: {name}", passed
            spent += seconds
            passed += 1
        return "", passed


def copy_of(header):
    return WORK / "include" / header.relative_to(HEADERS.parent)


def catch_main():
    path = WORK / "main.o"
    if not path.exists():
        subprocess.run([*CLANG, "-c", str(ROOT / "tests/main.cpp"), "-o", str(path)], check=True)
    return path


def culprits(errors, mutants):
    """The numbers of the mutants that may cause each error. Searches the lines that the error and its notes name,
    then up to three lines below: a compiler may report the line where an expression begins."""
    lines = {}
    for m in mutants:
        lines.setdefault((str(copy_of(m.path)), m.line), []).append(m.number)
    bad = set()
    for error in re.split(r"(?m)^(?=\S+:\d+:\d+: (?:fatal )?error)", errors)[1:]:
        named = [(path, int(line)) for path, line in re.findall(r"(?m)^(\S+?):(\d+):\d+: ", error)]
        near = (lines.get((path, line + below)) for below in range(4) for path, line in named)
        bad.update(next(filter(None, near), []))
    return bad


def read_options():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=random.randrange(1 << 30))
    parser.add_argument("--folders", default=",".join(sum(PROGRAMS.values(), [])))
    parser.add_argument("--at", nargs="*", default=[])
    parser.add_argument("--only", default="")
    parser.add_argument("--most", type=float, default=30)
    parser.add_argument("--flags", default="")
    return parser.parse_args()


def draw(finder, options):
    """The mutants of a run, and the functions to look after; all have numbers."""
    places = [m for m in finder.found if m.folder in options.folders.split(",")]
    drawn = random.Random(options.seed).sample(places, min(options.count, len(places)))
    drawn += [m for m in finder.found if m.place in options.at and m not in drawn]
    for number, m in enumerate(drawn + finder.functions, 1):
        m.number = number
    if options.only:
        drawn = [m for m in drawn if str(m.number) in options.only.split(",")]
    folders = {m.folder for m in drawn}
    print(f"seed {options.seed}: {len(drawn)} mutants drawn of {len(places)} places", flush=True)
    return drawn, [f for f in finder.functions if f.folder in folders]


def main():
    options = read_options()
    os.nice(5)
    subprocess.run(["sh", str(ROOT / "cmake/install_packages.sh"), *PACKAGES], check=True)
    WORK.mkdir(parents=True, exist_ok=True)
    headers = {path: path.read_bytes() for path in HEADERS.rglob("*.hpp")}  # whatever is edited meanwhile
    finder = Finder()
    drawn, functions = draw(finder, options)
    alive, programs, passed, built = drawn + functions, [], {}, 0

    def show(what, m, by):
        print(f"{m.number:5} {what} {m.place}:{m.column}: {m.what}   [{by}]", flush=True)

    for name, folders in PROGRAMS.items():
        if not any(m.folder in folders for m in drawn):
            continue
        start = time.time()
        program = Program(name, finder.functions[-1].number + 1, options.flags.split())
        alive = program.build(headers, alive)
        made = time.time()
        program.record()
        programs.append(program)
        own = [m for m in alive if m.folder in folders and m in drawn]
        built += len(own)
        print(f"{name}: built in {made - start:.0f} s, ran in {time.time() - made:.0f} s, {len(own)} mutants",
              flush=True)
        for m in own:
            by, cases = program.judge(m, options.most)
            show("killed" if by else "passed", m, by or cases)
            if not by:
                passed[m] = (program, cases)
    survived = 0
    for m, (own, cases) in passed.items():
        by = ""
        for program in programs:
            if program is not own and not by:
                by, more = program.judge(m, options.most)
                cases += more
        survived += not by
        show("killed" if by else "SURVIVED" if cases else "NOT REACHED", m, by or cases)
    reached = set().union(*(case[2] for program in programs for case in program.cases))
    for f in functions:
        if f.number not in reached:
            print(f"      NOT CALLED {f.place}: {f.what}")
    times = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"drawn {len(drawn)}, compiled {built}, killed {built - survived}, survived {survived}; "
          f"{(times.ru_utime + times.ru_stime) / 60:.0f} minutes of processors")


if __name__ == "__main__":
    main()
