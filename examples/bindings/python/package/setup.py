"""The wheel contains the shared library: one wheel per platform, for any Python 3."""

import pathlib
import re

from setuptools import setup

try:
    from setuptools.command.bdist_wheel import bdist_wheel  # setuptools 70.1 and later
except ImportError:
    from wheel.bdist_wheel import bdist_wheel


def tag(platform):
    """Returns the platform in the wheel's name; for Linux it contains the glibc version that the library needs."""
    library = pathlib.Path('cageform/libcageform.so')
    if not platform.startswith('linux_') or not library.exists():
        return platform
    needed = [int(minor) for minor in re.findall(rb'GLIBC_2\.(\d+)', library.read_bytes())]
    return platform.replace('linux', 'manylinux_2_%d' % max(needed))


class PlatformWheel(bdist_wheel):
    def finalize_options(self):
        super().finalize_options()
        self.root_is_pure = False

    def get_tag(self):
        return 'py3', 'none', tag(super().get_tag()[2])


setup(cmdclass={'bdist_wheel': PlatformWheel})
