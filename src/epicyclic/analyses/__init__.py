"""One System to a labelled Dataset: modes, static equilibrium, load sharing, periodic response, stability, transients.

Depends on: system, results.  Among themselves the rooms import in one direction:

    static <- modes <- steady <- sharing, stability, sensitivity, samples, modulation
    static, modes <- transient;  steady, stability, transient <- contact_loss

`static` holds the linearisation of links with laws that modes and linear response stand on, and the record of
instants.  `steady` never imports `sharing`.
"""
