"""Tests of the add-on in Blender's background:

    blender -b --python-exit-code 1 --python test.py -- cageform_blender.zip [NAME…]

Installs the zip file into the scripts folder of BLENDER_USER_SCRIPTS.
"""

import os
import sys
import unittest
import zipfile

import bpy

archive = os.path.abspath(sys.argv[sys.argv.index('--') + 1])
bpy.ops.preferences.addon_install(filepath=archive, overwrite=True)
bpy.ops.preferences.addon_enable(module='cageform')
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))


TESTS = ('test_following', 'test_pins', 'test_wrap', 'test_export', 'test_files', 'test_wrong')


class Install(unittest.TestCase):
    def test_archive(self):
        """The zip file has one folder, with the manifest of extensions at its root, and the library."""
        with zipfile.ZipFile(archive) as file:
            names = file.namelist()
            manifest = file.read('cageform/blender_manifest.toml').decode()
        self.assertEqual({name.split('/')[0] for name in names}, {'cageform'}, 'there is one folder in the zip')
        self.assertIn('cageform/library/libcageform.so', names, 'the library is in the zip')
        import cageform
        version = '.'.join(str(number) for number in cageform.bl_info['version'])
        self.assertIn('version = "%s"' % version, manifest, 'the manifest has the version of bl_info')
        self.assertEqual(cageform.library.__version__, version, 'the add-on has the version of the library')

    def test_again(self):
        """The add-on can be disabled and enabled again."""
        bpy.ops.preferences.addon_disable(module='cageform')
        self.assertFalse(hasattr(bpy.types.Object, 'cageform'), 'nothing is left when it is off')
        bpy.ops.preferences.addon_enable(module='cageform')
        self.assertTrue(hasattr(bpy.types.Object, 'cageform'))


if __name__ == '__main__':
    chosen = sys.argv[sys.argv.index('--') + 2:]  # test_pins, test_pins.Pins.test_moved; none: all
    suites = [unittest.defaultTestLoader.loadTestsFromName(name) for name in chosen or TESTS]
    if not chosen:
        suites.insert(0, unittest.defaultTestLoader.loadTestsFromTestCase(Install))
    result = unittest.TextTestRunner(verbosity=2).run(unittest.TestSuite(suites))
    sys.exit(0 if result.wasSuccessful() else 1)
