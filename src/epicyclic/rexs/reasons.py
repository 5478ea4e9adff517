"""Why what is in a REXS file has no place in a model file, by type of component."""

from __future__ import annotations

__all__ = ["reason_of"]

_REASONS = {
    "lubricant": "no lubricant in the model",
    "material": "strength and heat are not computed",
    "shaft": "shafts do not bend in the model",
    "shaft_section": "shafts do not bend in the model",
    "side_plate": "plates do not bend in the model",
    "gear_casing": "the casing is rigid",
    "cylindrical_stage": "load capacity, tolerances and results are not carried",
    "cylindrical_gear": "no place in the model: places follow from the centres and faces; no load capacity or results",
    "ring_gear": "no place in the model: places follow from the centres and faces; no load capacity or results",
    "coupling": "inside a member, or rigid",
    "switchable_coupling": "inside a member, or rigid",
    "external_load": "follows from the operation",
    "stage_gear_data": "results of a mesh are not carried",
    "cylindrical_stage_gear_data": "results of a mesh are not carried",
    "flank_geometry": "allowances and chamfers are not carried",
    "cylindrical_gear_flank": "allowances and chamfers are not carried",
    "rack_shaped_tool": "of tools, height and rounding of the tip are carried",
    "cutter_wheel_tool": "of tools, height and rounding of the tip are carried",
    "cylindrical_gear_manufacturing_settings": "allowances are not carried",
    "profile_crowning": "the model has tip and root relief, no profile crowning",
    "helix_slope": "its sense against the loaded flank is not known",
    "rolling_element": "bearings are springs in the model",
}


def reason_of(kind: str) -> str:
    """Reason for a type of component."""
    if "bearing" in kind:
        return "clearance, size, misalignment and results of bearings are not carried"
    return _REASONS.get(kind, "no place in the model file")
