"""What exists, frozen: bodies, connections, kinematics, the resolved train.

Depends on: gears.
"""
