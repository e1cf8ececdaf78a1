"""Tables and figures of the papers that the bundled robots come from, one module a paper.

Each has a function ``reproduce(directory)`` that writes its files and returns their paths;
``agrik-fast paper NAME -o DIR`` calls it.
"""
