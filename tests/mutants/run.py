#!/usr/bin/python3
"""Usage: /usr/bin/python3 tests/mutants/run.py [--count 200] [--seed N] [--folders animate,enclose] [--at FILE:LINE …]

Changes the headers at random places and tells which changes no test notices, and which functions no test calls (of more
than one statement). Not part of CI: 200 mutants take about 40 minutes of a processor. Installs what it needs, on Debian 12.

One build holds all mutants of a run. A copy of the headers has `(cageform_mutant(17) ? (a <= b) : (a < b))` in the place of
`a < b`; the environment says at run time which one is alive. What does not compile is dropped. Each test program runs once
without a mutant, which records the time of each test case and the mutants that it reaches. Then each mutant of the program's
folders runs against the cases that reach it, each a process, short ones first, until one fails; survivors run against the
other programs' cases too. A case that takes more than five times as long as without the mutant, and two seconds, has failed.

  --count    how many mutants are drawn from all places
  --seed     of the draw; it is printed, so that a run can be repeated
  --folders  of include/cageform; all unless told
  --at       all mutants of these lines as well, as in enclose/make_cage.hpp:199
  --only     of those drawn, only these numbers, as in 3,17
  --most     seconds of test cases that a mutant survives before it counts as survived
  --flags    more for the compiler, as -fsanitize=address,undefined
"""
import argparse
import os
import pathlib
import random
import re
import resource
import subprocess
import sys
import time

from places import EIGEN, HEADERS, ROOT, Finder, rewritten

WORK = ROOT / "build" / "mutants"
PACKAGES = "clang-19 python3-clang-19 libeigen3-dev libglm-dev nlohmann-json3-dev catch2".split()
PROGRAMS = {  # as in tests/CMakeLists.txt: the folders of a program
    "core_adapt": ["core", "adapt"],
    "animate": ["animate"],
    "enclose": ["enclose"],
    "binding_clone": ["binding", "clone"],
    "coordinates_grid_surface_cage": ["coordinates", "grid", "surface", "cage"],
}


class Program:
    """A test program with the mutants that it is made with."""

    def __init__(self, name, size, flags):
        self.name, self.flags, self.size = name, flags, size
        self.path = WORK / name
        self.cases = []

    def compiler(self):
        return ["clang++-19", "-std=c++20", "-O1", "-w", "-Wno-c++11-narrowing", "-D_GLIBCXX_ASSERTIONS", "-pthread",
                "-ferror-limit=0", f"-DCAGEFORM_MUTANTS={self.size}", "-DCATCH_CONFIG_EXTERNAL_INTERFACES",
                f'-DCAGEFORM_TEST_DATA="{ROOT}/tests/data"', "-include", str(ROOT / "tests/mutants/mutant.hpp"),
                "-I", str(WORK / "include"), "-I", str(ROOT / "tests"), *EIGEN, *self.flags]

    def build(self, headers, mutants):
        """Compiles all tests as one file until that goes, each time without the mutants at whose lines errors are; those
        that are left."""
        files = [f for folder in PROGRAMS[self.name] for f in sorted((ROOT / "tests" / folder).glob("*.cpp"))]
        source = self.path.with_suffix(".cpp")
        source.write_text("".join(f'#include "{f}"\n' for f in [ROOT / "tests/mutants/recorder.hpp", *files]))
        while True:
            for path, text in headers.items():
                copy = WORK / "include" / path.relative_to(HEADERS.parent)
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
        subprocess.run([str(self.path)], env={**os.environ, "MUTANTS_RECORD": str(path)}, stdout=subprocess.DEVNULL)
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
            if not self.flags:  # sanitizers take all addresses
                resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))

        try:
            run = subprocess.run([str(self.path), "--abort", pattern], preexec_fn=limited, timeout=20 * limit + 60,
                                 env={**os.environ, "MUTANT": str(number)}, capture_output=True)
        except subprocess.TimeoutExpired:
            return "out of time"
        code = run.returncode
        if b"No tests ran" in run.stdout:
            sys.exit(f"no test case is called {pattern}")
        return "out of time" if code in (-24, -9) else "crashed" if code < 0 else "failed" if code else ""

    def judge(self, mutant, most):
        """Killed by what, or how many cases the mutant survived."""
        spent, survived = 0.0, 0
        for seconds, name, reached in self.cases:
            if mutant.number not in reached or spent > most:
                continue
            how = self.fails(mutant.number, seconds, name)
            if how:
                return f"{how}: {name}", survived
            spent += seconds
            survived += 1
        return "", survived


def catch_main():
    path = WORK / "main.o"
    if not path.exists():
        subprocess.run(["clang++-19", "-std=c++20", "-w", "-c", str(ROOT / "tests/main.cpp"), "-o", str(path)], check=True)
    return path


def culprits(errors, mutants):
    """The numbers of the mutants at the line of each error, else at the nearest line that its notes name."""
    lines = {}
    for m in mutants:
        lines.setdefault((str(WORK / "include/cageform" / m.path.relative_to(HEADERS)), m.line), []).append(m.number)
    bad = set()
    for error in re.split(r"(?m)^(?=\S+:\d+:\d+: (?:fatal )?error)", errors)[1:]:
        named = (lines.get((path, int(line))) for path, line in re.findall(r"(?m)^(\S+?):(\d+):\d+: ", error))
        bad.update(next(filter(None, named), []))
    return bad


def read_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=random.randrange(1 << 30))
    parser.add_argument("--folders", default=",".join(sum(PROGRAMS.values(), [])))
    parser.add_argument("--at", nargs="*", default=[])
    parser.add_argument("--only", default="")
    parser.add_argument("--most", type=float, default=60)
    parser.add_argument("--flags", default="")
    return parser.parse_args()


def main():
    options = read_options()
    os.nice(5)
    subprocess.run(["sh", str(ROOT / "cmake/install_packages.sh"), *PACKAGES], check=True)
    WORK.mkdir(parents=True, exist_ok=True)
    headers = {path: path.read_bytes() for path in HEADERS.rglob("*.hpp")}  # whatever is edited meanwhile
    finder = Finder()
    places = [m for m in finder.found if m.folder in options.folders.split(",")]
    drawn = random.Random(options.seed).sample(places, min(options.count, len(places)))
    drawn += [m for m in finder.found if m.place in options.at and m not in drawn]
    for number, m in enumerate(drawn + finder.functions, 1):
        m.number = number
    if options.only:
        drawn = [m for m in drawn if str(m.number) in options.only.split(",")]
    folders = {m.folder for m in drawn}
    functions = [f for f in finder.functions if f.folder in folders]
    print(f"seed {options.seed}: {len(drawn)} mutants drawn of {len(places)} places", flush=True)

    alive, programs, survivors = drawn + functions, [], []
    killed = built = 0
    for name, own in PROGRAMS.items():
        if not folders & set(own):
            continue
        start = time.time()
        program = Program(name, max(m.number for m in drawn + finder.functions) + 1, options.flags.split())
        alive = program.build(headers, alive)
        mutants = [m for m in alive if m.folder in own and m in drawn]
        made = time.time()
        program.record()
        programs.append(program)
        print(f"{name}: built in {made - start:.0f} s, ran in {time.time() - made:.0f} s, {len(mutants)} mutants", flush=True)
        built += len(mutants)
        for m in mutants:
            by, survived = program.judge(m, options.most)
            killed += bool(by)
            print(f"{m.number:5} {'killed' if by else 'passed'} {m.place}: {m.what}   [{by or survived}]", flush=True)
            if not by:
                survivors.append([m, program, survived])
    for entry in survivors:
        m, own, survived = entry
        for program in programs:
            by, more = program.judge(m, options.most) if program is not own and entry[2] >= 0 else ("", 0)
            entry[2] = -1 if by else entry[2] + more if entry[2] >= 0 else -1
            killed += bool(by)
    for m, _, survived in survivors:
        if survived >= 0:
            print(f"{m.number:5} {'SURVIVED' if survived else 'NOT REACHED'} {m.place}: {m.what}   [{survived}]")
    reached = set().union(*(case[2] for program in programs for case in program.cases))
    for f in functions:
        if f.number not in reached:
            print(f"      NOT CALLED {f.place}: {f.what}")
    times = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"drawn {len(drawn)}, compiled {built}, killed {killed}, survived {built - killed}; "
          f"{(times.ru_utime + times.ru_stime) / 60:.0f} minutes of processors")


if __name__ == "__main__":
    main()
