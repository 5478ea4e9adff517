"""The ready drives, one TOML file each, named by their source.

Depends on: nothing; read by files.
"""
