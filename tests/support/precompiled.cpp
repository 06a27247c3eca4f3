// A library needs a source of its own to make the precompiled header of the tests.
