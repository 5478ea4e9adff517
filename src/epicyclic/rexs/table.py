"""What of REXS has a place in a model, said once for both ways: attributes of components, relations, words, units.

The import finds the kind of quantity of an attribute here, its key in the table that the component becomes, and how it
is spelled there.  The export walks the rows of a type, takes each value of the part of the train that is written, and
finds its unit here.  An attribute that is more than one number of a part (places, the hand of a gear, profile shifts
that follow, what a joint holds) has its row too; what becomes of it is code of the one way or the other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from operator import attrgetter
from typing import Literal, NamedTuple

from .file import Number, Value


class RexsRow(NamedTuple):
    """An attribute.

    type : of the component that has it, of several alike the one that is written; ``place``, ``on_shaft`` of all that
    stand somewhere.  id : of the standard.  unit : of version 1.7, which is written; what is read has its own.
    key : in the table of a model file that the component becomes; empty where it is more than this value.
    of : the value in SI in the part of the train that is written, ``gear.tip_radius``, and how many times; empty where
    the export computes it, or does not write it.
    magnitude : read without its sign; an angle of 0 is none.  form : of its value.
    default : in SI, where the model does not state it.  note : what is assumed where it is read.
    """

    type: str
    id: str
    unit: str = "none"
    key: str = ""
    of: str = ""
    times: float = 1
    magnitude: bool = False
    form: Literal["scalar", "array", "word", "component"] = "scalar"
    default: float = 0.0
    note: str = ""

    def entry(self, number: Number | None) -> object:
        """What a number becomes in a model file: its text, of a ratio the number; None where it is not given."""
        if number is None or (self.magnitude and self.unit == "deg" and not number.si):
            return None
        if self.unit == "none":
            return number.si
        return abs(number).text if self.magnitude else number.text


HELIX = "helix_angle_reference_diameter"
CASE_NAME = "custom_load_case_name"  # the standard has no names of load cases, and leaves `custom_` to the user
_ROWS = (
    RexsRow("place", "reference_component_for_position", form="component"),
    RexsRow("place", "support_vector", "mm", form="array"),
    RexsRow("place", "u_axis_vector", "mm", form="array"),
    RexsRow("place", "w_axis_vector", "mm", form="array"),
    RexsRow("on_shaft", "u_coordinate_on_shaft", "mm"),
    RexsRow("gear_unit", "number_of_gears"),
    RexsRow("gear_unit", "gear_shift_index"),
    RexsRow("gear_unit", "account_for_gravity"),
    RexsRow("gear_unit", "gravitational_acceleration", "m / s^2"),
    *(RexsRow("gear_unit", f"direction_vector_gravity_{axis}") for axis in "uvw"),
    # of a load case; those of versions 1.0 to 1.2 behind those of 1.3 and later
    *(RexsRow("gear_unit", name, "h", "duration") for name in ("operating_time", "load_duration")),
    *(RexsRow("gear_unit", f"{name}_fraction", "%", "share") for name in ("operating_time", "load_duration")),
    RexsRow("gear_unit", CASE_NAME),
    RexsRow("shaft", "rotational_speed", "1 / min"),
    RexsRow("shaft", "defines_speed"),
    RexsRow("shaft_section", "length", "mm"),
    *(
        RexsRow("shaft_section", f"{side}_diameter_{end}", "mm")
        for side in ("outer", "inner")
        for end in ("begin", "end")
    ),
    *(RexsRow("side_plate", f"{side}_diameter", "mm") for side in ("outer", "inner")),
    RexsRow("additional_mass", "mass", "kg", of="mass"),
    RexsRow("additional_mass", "moment_of_inertia_u_axis", "kg m^2", of="polar"),
    *(RexsRow("additional_mass", f"moment_of_inertia_{axis}_axis", "kg m^2", of="tilt") for axis in "vw"),
    RexsRow("external_load", "torque_around_u_axis", "N m"),
    RexsRow("external_load", "power", "kW"),
    RexsRow("external_load", "transmits_torque"),
    RexsRow("external_load", "defines_torque"),
    RexsRow("coupling", "radial_stiffness", "N / m", "radial"),
    RexsRow("coupling", "axial_stiffness", "N / m", "z"),
    RexsRow("coupling", "bending_stiffness", "N mm / rad", "tilt"),
    RexsRow("coupling", "rotational_stiffness", "N mm / rad", "rz"),
    RexsRow("coupling", "is_engaged", form="array"),
    RexsRow("coupling", "u_coordinate_on_shaft_inner_side", "mm"),
    RexsRow("concept_bearing", "radial_force_absorption"),
    RexsRow("concept_bearing", "axial_force_absorption", form="word"),
    *(RexsRow("concept_bearing", f"operating_point_stiffness_f_{axis}_d_{axis}", "N / m", "radial") for axis in "vw"),
    RexsRow("cylindrical_gear", "number_of_teeth", "none", "teeth", "gear.teeth", magnitude=True),
    RexsRow("cylindrical_gear", "normal_module", "mm", "module", "gear.module"),
    RexsRow("cylindrical_gear", HELIX, "deg", "helix_angle", "helix", magnitude=True),
    RexsRow("cylindrical_gear", "face_width", "mm", "face_width", "gear.face_width"),
    RexsRow("cylindrical_gear", "tip_diameter", "mm", "tip_diameter", "gear.tip_radius", 2, magnitude=True),
    RexsRow("cylindrical_gear", "root_diameter", "mm", "root_diameter", "gear.root_radius", 2, magnitude=True),
    RexsRow("cylindrical_gear", "transverse_module", "mm"),
    RexsRow("cylindrical_gear", "addendum_coefficient_basic_profile", "none", "addendum"),
    RexsRow("cylindrical_gear_flank", "normal_pressure_angle", "deg", "pressure_angle", "pressure_angle"),
    RexsRow("cylindrical_gear_flank", "addendum_modification_coefficient", "none", "profile_shift", "profile_shift"),
    RexsRow("cylindrical_gear_flank", "profile_shift_coefficient", "none", "profile_shift"),
    RexsRow("tip_relief", "tip_relief_depth", "mum", "amount", "amount"),
    RexsRow("tip_relief", "tip_relief_amount", "mum", "amount"),
    RexsRow("tip_relief", "tip_relief_datum_diameter", "mm"),
    RexsRow("tip_relief", "shape_of_relief", "none", "shape", "shape", form="word"),
    RexsRow("root_relief", "root_relief_depth", "mum", "amount"),
    RexsRow("root_relief", "root_relief_amount", "mum", "amount"),
    RexsRow("root_relief", "root_relief_datum_diameter", "mm"),
    *(
        RexsRow("helix_crowning", f"helix_crowning_amount_{end}_face", "mum", of="crown")
        for end in ("datum", "non_datum")
    ),
    RexsRow("helix_slope", "datum_face_orientation", form="word"),
    RexsRow("rack_shaped_tool", "addendum_coefficient_reference_profile", "none", "dedendum"),
    RexsRow("rack_shaped_tool", "tip_radius_factor", "none", "tip_rounding"),
    RexsRow("material", "density", "kg / dm^3", "density", default=7850.0),
    RexsRow("material", "elastic_modulus", "N / mm^2", "youngs_modulus", default=206e9),
    RexsRow("material", "poisson_ratio", "none", "poisson_ratio", default=0.3),
    RexsRow("cylindrical_stage", "center_distance", "mm", "centre_distance"),
    RexsRow("cylindrical_stage", "rotating_angle_around_neg_u_axis", "deg"),
    RexsRow("cylindrical_stage", "working_transverse_pressure_angle", "deg", of="pressure_angle"),
    RexsRow("cylindrical_stage", "transverse_contact_ratio", of="contact_ratio"),
    RexsRow("cylindrical_stage", "overlap_ratio", of="overlap_ratio"),
    RexsRow("cylindrical_stage", "common_face_width", "mm", of="width"),
    # of the stiffnesses the first that is given counts, the first of all is written
    RexsRow("cylindrical_stage", "mean_mesh_stiffness_for_transverse_load_iso_6336_2019", "N / (mm mum)", "stiffness"),
    RexsRow(
        "cylindrical_stage",
        "mesh_stiffness_for_load_distribution_along_face_width",
        "N / (mm mum)",
        "stiffness",
        note="a value for the load along the face: taken as the mean",
    ),
    *(RexsRow("cylindrical_stage", f"{end}_normal_backlash", "mm", of="backlash") for end in ("minimum", "maximum")),
    RexsRow("cylindrical_stage", "mesh_load_factor_iso_6336_2019"),
    RexsRow("cylindrical_stage", "dynamic_factor_iso_6336_2019"),
    RexsRow("cylindrical_stage", "face_load_factor_contact_stress_iso_6336_2019"),
    RexsRow("cylindrical_stage", "transverse_load_factor_contact_stress_iso_6336_2019"),
    RexsRow("cylindrical_stage_gear_data", "is_driving_gear"),
    RexsRow("cylindrical_stage_gear_data", "torque", "N m"),
    RexsRow("cylindrical_stage_gear_data", "number_of_load_cycles"),
)


def rows_of(kind: str, key: str = "") -> list[RexsRow]:
    """Rows of a type of components; those of one key of a model file where it is given."""
    return [row for row in _ROWS if row.type == kind and key in ("", row.key)]


ROW = {row.id: row for row in _ROWS}
"""Id of an attribute -> its row; an id is the same in every type."""
BEARINGS = (
    "concept_bearing",
    "rolling_bearing_with_catalog_geometry",
    "rolling_bearing_with_detailed_geometry",
    "slide_bearing",
    "hydrodynamic_radial_plain_bearing",
)
PLACE = [row.id for row in rows_of("place")]
ARRAYS, WORDS, REFERENCES = ([row.id for row in _ROWS if row.form == form] for form in ("array", "word", "component"))
# what the gears of a stage mostly share: it stands with the stage then
SHARED = ("module", "helix_angle", "face_width", "pressure_angle")
RELIEF_SHAPES = {"linear": "linear", "parabolic": "parabolic", "quadratic": "parabolic"}

RELATIONS = {
    "assembly": ("assembly", "part"),
    "reference": ("origin", "referenced"),
    **dict.fromkeys(
        ("planet_shaft", "planet_pin", "planet_carrier_shaft", "central_shaft"), ("planetary_stage", "shaft")
    ),
    "side": ("assembly", "inner_part", "outer_part"),
    "stage": ("stage", "gear_1", "gear_2"),
    "stage_gear_data": ("stage", "gear", "stage_gear_data"),
    "flank": ("gear", "left", "right"),
    "manufacturing_step": ("workpiece", "tool"),
}
"""Type of a relation -> roles of its parts, in the order in which they are written."""

_DROPPED = {
    ("lubricant",): "no lubricant in the model",
    ("material",): "strength and heat are not computed",
    ("shaft", "shaft_section"): "read as mass; shaft_sections of a member makes its shaft bend",
    ("side_plate",): "plates do not bend in the model",
    ("gear_casing",): "the casing is rigid",
    ("cylindrical_stage",): "load capacity, tolerances and results are not carried",
    ("cylindrical_gear", "ring_gear"): (
        "no place in the model: places follow from the centres and faces; no load capacity or results"
    ),
    ("coupling", "switchable_coupling"): "inside a member, or rigid",
    ("external_load",): "follows from the operation",
    ("stage_gear_data", "cylindrical_stage_gear_data"): "results of a mesh are not carried",
    ("flank_geometry", "cylindrical_gear_flank"): "allowances and chamfers are not carried",
    ("rack_shaped_tool", "cutter_wheel_tool"): "of tools, height and rounding of the tip are carried",
    ("cylindrical_gear_manufacturing_settings",): "allowances are not carried",
    ("profile_crowning",): "the model has tip and root relief, no profile crowning",
    ("helix_slope",): "its sense against the loaded flank is not known",
    ("rolling_element",): "bearings are springs in the model",
}


def reason_dropped(kind: str) -> str:
    """Why the attributes of a type of components that are not asked for are dropped."""
    if "bearing" in kind:
        return "clearance, size, misalignment and results of bearings are not carried"
    return next((reason for kinds, reason in _DROPPED.items() if kind in kinds), "no place in the model file")


def values_of(kind: str, part: object, given: Mapping[str, Value] | None = None) -> dict[str, Value]:
    """Values of a component in SI by id, in the order of its rows: those given, and what a part of a train has."""
    values = {}
    for row in rows_of(kind):
        if given and row.id in given:
            values[row.id] = given[row.id]
        elif row.of:
            value = attrgetter(row.of)(part)
            if isinstance(value, str):
                values[row.id] = value
            elif value is not None and math.isfinite(value):
                values[row.id] = row.times * value
    return values
