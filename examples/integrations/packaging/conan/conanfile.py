"""The recipe for the sources of this repository: conan create examples/integrations/packaging/conan (Conan 2)."""

import os
import re

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load


class Cageform(ConanFile):
    name = 'cageform'
    description = 'Cage-based deformation: bind a figure once, clone it at memory speed'
    license = 'MIT'
    topics = ('deformation', 'animation', 'geometry')
    package_type = 'library'
    settings = 'os', 'arch', 'compiler', 'build_type'
    # compiled: includes cageform::compiled, the library with the C interface; otherwise only headers.
    options = {'compiled': [True, False], 'shared': [True, False], 'fPIC': [True, False]}
    default_options = {'compiled': False, 'shared': False, 'fPIC': True}

    @property
    def _root(self):
        return os.path.join(self.recipe_folder, *['..'] * 4)

    def set_version(self):
        text = load(self, os.path.join(self._root, 'include', 'cageform', 'version.hpp'))
        self.version = re.search(r'VERSION_STRING "(.*)"', text).group(1)

    def export_sources(self):
        for pattern in ('CMakeLists.txt', 'LICENSE', 'include/*', 'cmake/*'):
            copy(self, pattern, self._root, self.export_sources_folder)

    def config_options(self):
        if self.settings.os == 'Windows':
            del self.options.fPIC

    def configure(self):
        if not self.options.compiled:
            self.package_type = 'header-library'
            del self.options.shared
        if not self.options.compiled or self.options.shared:
            self.options.rm_safe('fPIC')

    def requirements(self):
        self.requires('eigen/3.4.0', transitive_headers=True)

    def validate(self):
        check_min_cppstd(self, 20)

    def package_id(self):
        if not self.info.options.compiled:
            self.info.settings.clear()

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for name, value in (('COMPILED', bool(self.options.compiled)), ('TESTS', False), ('EXAMPLES', False)):
            toolchain.cache_variables['CAGEFORM_BUILD_' + name] = value
        toolchain.cache_variables['CAGEFORM_INSTALL'] = True
        toolchain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        if self.options.compiled:
            cmake.build(target='cageform_compiled')

    def package(self):
        CMake(self).install()

    def package_info(self):
        # find_package(cageform) finds the CMake files that the project installs.
        self.cpp_info.set_property('cmake_find_mode', 'none')
        self.cpp_info.builddirs = [os.path.join('share', 'cmake', 'cageform')]
        self.cpp_info.bindirs = []
        self.cpp_info.libs = ['cageform'] if self.options.compiled else []
        if not self.options.compiled:
            self.cpp_info.libdirs = []
        if self.options.compiled:
            self.cpp_info.defines = ['CAGEFORM_COMPILED']
            if self.settings.os in ('Linux', 'FreeBSD') and not self.options.shared:
                self.cpp_info.system_libs = ['m', 'pthread']
