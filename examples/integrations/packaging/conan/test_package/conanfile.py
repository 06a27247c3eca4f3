"""Builds a C++ program with the package, and a C program if the package has cageform::compiled."""

import os

from conan import ConanFile
from conan.tools.build import can_run
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout


class CageformTest(ConanFile):
    settings = 'os', 'arch', 'compiler', 'build_type'

    def requirements(self):
        self.requires(self.tested_reference_str)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables['COMPILED'] = bool(self.dependencies['cageform'].options.compiled)
        toolchain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def test(self):
        if can_run(self):
            for name in ('client', 'client_c'):
                program = os.path.join(self.cpp.build.bindir, name)
                if os.path.exists(program):
                    self.run(program, env='conanrun')
