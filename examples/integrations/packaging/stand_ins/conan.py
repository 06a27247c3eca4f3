"""python3 conan.py RECIPE BUILD PACKAGE [NAME=VALUE …]

Runs the methods of a recipe with the parts of Conan 2 that they need, without Conan. Options are given as compiled=True.
"""

import importlib.util
import pathlib
import shutil
import subprocess
import sys
import types


class Options(dict):
    __getattr__ = dict.__getitem__
    __delattr__ = dict.__delitem__

    def rm_safe(self, name):
        self.pop(name, None)


class Recipe:
    def __init__(self, folder, package):
        self.recipe_folder, self.package_folder = str(folder), str(package)
        self.export_sources_folder = str(package / 'sources')
        self.settings = types.SimpleNamespace(os='Linux', clear=lambda: None)
        self.options = Options(self.default_options)
        self.cpp_info = types.SimpleNamespace(set_property=lambda *_: None, bindirs=['bin'], libdirs=['lib'])
        self.required = []

    def requires(self, *reference, **_):
        self.required += reference


class Dependencies:
    def __init__(self, _):
        pass

    def generate(self):
        pass


class Toolchain:
    last = None

    def __init__(self, _):
        self.cache_variables = {}
        Toolchain.last = self

    def generate(self):
        pass


class CMake:
    build_folder = None

    def __init__(self, recipe):
        self.recipe = recipe

    def configure(self):
        options = dict(Toolchain.last.cache_variables, BUILD_SHARED_LIBS=self.recipe.options.get('shared', False))
        # An existing build is continued, with its own sources.
        cache = pathlib.Path(self.build_folder, 'CMakeCache.txt')
        lines = cache.read_text(encoding='utf-8').splitlines() if cache.exists() else []
        homes = [line.partition('=')[2] for line in lines if line.startswith('CMAKE_HOME_DIRECTORY:')]
        run('-S', (homes + [self.recipe.export_sources_folder])[0], '-B', self.build_folder, '-G', 'Ninja', '-DCMAKE_BUILD_TYPE=Release',
            *['-D%s=%s' % (name, 'ON' if value else 'OFF') for name, value in options.items()])

    def build(self, target):
        run('--build', self.build_folder, '--target', target)

    def install(self):
        run('--install', self.build_folder, '--prefix', self.recipe.package_folder)


def run(*arguments):
    done = subprocess.run(('cmake',) + arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    if done.returncode:
        raise SystemExit(done.stdout.decode())


def copy(_, pattern, source, target):
    source, target = pathlib.Path(source).resolve(), pathlib.Path(target)
    found = sorted(source.glob(pattern))
    if not found:
        raise SystemExit('the recipe exports %s, which does not exist' % pattern)
    for path in found:
        (target / path.relative_to(source)).parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if path.is_dir() else shutil.copy)(path, target / path.relative_to(source))


def module(name, **members):
    sys.modules[name] = types.ModuleType(name)
    vars(sys.modules[name]).update(members)


def main(path, build, package, *options):
    module('conan', ConanFile=Recipe)
    module('conan.tools')
    module('conan.tools.build', check_min_cppstd=lambda *_: None)
    module('conan.tools.cmake', CMake=CMake, CMakeDeps=Dependencies, CMakeToolchain=Toolchain, cmake_layout=lambda _: None)
    module('conan.tools.files', copy=copy, load=lambda _, name: pathlib.Path(name).read_text(encoding='utf-8'))
    spec = importlib.util.spec_from_file_location('recipe', path)
    recipe = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(recipe)
    CMake.build_folder = build
    shutil.rmtree(package, ignore_errors=True)
    its = recipe.Cageform(pathlib.Path(path).resolve().parent, pathlib.Path(package).resolve())
    its.options.update((name, value == 'True') for name, value in (option.split('=') for option in options))
    its.info = types.SimpleNamespace(options=its.options, settings=its.settings)
    for method in ('set_version', 'export_sources', 'config_options', 'configure', 'requirements', 'validate', 'package_id',
                   'layout', 'generate', 'build', 'package', 'package_info'):
        getattr(its, method)()
    print('%s/%s requires %s' % (its.name, its.version, ', '.join(its.required)))


if __name__ == '__main__':
    main(*sys.argv[1:])
