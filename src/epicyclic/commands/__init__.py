"""The commands of the command line, one file each; `cli` puts them together.

Depends on: console, terminal, studies, results, report, files.
"""
