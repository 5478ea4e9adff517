"""Document to Train: frozen data of bodies, connections, kinematics, phases, power; and a new train.

Depends on: document, teeth.  Modules of the Train itself know no document.
"""
