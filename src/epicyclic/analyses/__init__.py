"""One System to a labelled Dataset: modes, load sharing, periodic response, stability, transients.

Depends on: statics, system, engine, results.  Among themselves the rooms import in one direction:

    modes <- steady <- sharing, stability, sensitivity, modulation
    modes <- transient;  steady, stability, transient <- contact_loss

`steady` never imports `sharing`.
"""
