"""The resolved train as frozen data: bodies, connections, kinematics, mesh phases, power flow.

Depends on: teeth.
"""
