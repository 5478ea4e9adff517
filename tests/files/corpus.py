"""Broken model files: what is wrong, and what the message must name.

A case changes one thing of `BASE`, a plain planetary set that is read, resolved and assembled without complaint.
`read` cases are found while the document is read, `resolve` cases only by geometry, kinematics or statics.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["BASE", "BYTES", "CASES", "Case"]

BASE = """\
format = 2
title = "a planetary set"
damping.modal = 0.03

[stages.main]
planets = 3
module = "4 mm"
face_width = "40 mm"

[stages.main.sun]
teeth = 24
support = { radial = "1e8 N/m" }

[stages.main.planet]
teeth = 24
bearing = { radial = "1e8 N/m" }

[stages.main.ring]
teeth = 72
rim = "30 mm"
support = { radial = "1e9 N/m" }

[stages.main.carrier]
mass = "20 kg"
inertia = "0.2 kg m^2"
support = { radial = "1e8 N/m" }

[operation]
held = ["ring"]
speed.sun = "1000 rpm"
torque.sun = "1 kN m"

[deviations]
sun.run_out = "10 um"
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One broken file: `old` replaced by `new` in BASE (without `old`: appended), and what the message must contain."""

    name: str
    new: str
    old: str = ""
    path: str
    given: str = ""
    allowed: str = ""
    stage: str = "read"

    @property
    def text(self) -> str:
        """The broken file."""
        if not self.old:
            return f"{BASE}\n{self.new}\n"
        assert BASE.count(self.old) == 1, f"{self.name}: {self.old!r} stands {BASE.count(self.old)} times"
        return BASE.replace(self.old, self.new)


def _read(name: str, old: str, new: str, path: str, given: str = "", allowed: str = "") -> Case:
    return Case(name=name, old=old, new=new, path=path, given=given, allowed=allowed)


def _resolve(name: str, old: str, new: str, path: str, given: str = "", allowed: str = "") -> Case:
    return Case(name=name, old=old, new=new, path=path, given=given, allowed=allowed, stage="resolve")


def _toleranced(name: str, entry: str, path: str, given: str, allowed: str) -> Case:
    return _read(name, "[deviations]", f"[tolerance]\n{entry}\n[deviations]", path, given, allowed)


SUN = "[stages.main.sun]\nteeth = 24"
PLANET = "[stages.main.planet]\nteeth = 24"
RING = "[stages.main.ring]\nteeth = 72"
SUN_TO_PLANET = BASE[BASE.index(SUN) : BASE.index(PLANET) + len(PLANET)]
SUN_SUPPORT = 'teeth = 24\nsupport = { radial = "1e8 N/m" }'
BEARING = 'bearing = { radial = "1e8 N/m" }'


RING_SUPPORT = 'support = { radial = "1e9 N/m" }'
SLICES = "[stages.main.meshes]\nsun-planet.slices"
ERROR = "meshes.sun-planet.errors.mine"


def _bolts(keys: str) -> str:
    """Return a support on bolts."""
    return f"support.bolts = {{ {keys} }}"


def _both(sun: str, planet: str) -> str:
    """Return the tables of sun and planet, each with a line more."""
    return SUN_TO_PLANET.replace(SUN, f"{SUN}\n{sun}").replace(PLANET, f"{PLANET}\n{planet}")


CASES: tuple[Case, ...] = (
    # the file as a whole
    _read("no-format", "format = 2\n", "", "format", "", "format = 2"),
    _read("older-format", "format = 2\n", "format = 1\n", "format", "1", "docs/reference/model-file.md"),
    _read("newer-format", "format = 2\n", "format = 3\n", "format", "3", "format = 2"),
    _read("format-text", "format = 2\n", 'format = "2"\n', "format", "2", "format = 2"),
    _read("format-true", "format = 2\n", "format = true\n", "format", "True", "format = 2"),
    _read("format-zero", "format = 2\n", "format = 0\n", "format", "0", "format = 2"),
    _read("no-title", 'title = "a planetary set"\n', "", "title", "", "one line"),
    _read("title-number", '"a planetary set"', "3", "title", "3", "a text"),
    _read("title-date", '"a planetary set"', "1979-05-27", "title", "1979", "a text"),
    _read("unknown-table", "[operation]", "[operatoin]", "operatoin", "held", "'operation'"),
    _read("no-stages", BASE[BASE.index("[stages.main]") :], "", "stages", "", "[stages.NAME]"),
    _read("stages-number", BASE[BASE.index("[stages.main]") :], "[x]\n", "x", "", "one of format, title"),
    _read("nan", "damping.modal = 0.03", "damping.modal = nan", "damping.modal", "nan", "a number"),
    _read("huge-float", "damping.modal = 0.03", "damping.modal = 1e999", "toml", "1e999", "TOML"),
    _read("unclosed", 'module = "4 mm"', 'module = "4 mm', "line 7", "", "TOML"),
    _read("twice", 'module = "4 mm"', 'module = "4 mm"\nmodule = "5 mm"', "line 8", "", "TOML"),
    _read("recursive", "planets = 3", "planets = " + "[" * 5000 + "]" * 5000, "toml", "", "levels"),
    _read("deep", "planets = 3", "planets" + ".a" * 60 + " = 1", "stages.main.planets.a", "", "at most 24 levels"),
    _read("thousand-digits", "planets = 3", "planets = " + "9" * 5000, "toml", "", "TOML"),
    # names
    _read("stage-name", "[stages.main]", '[stages."a/b"]\nmodule = 1\n[stages.main]', "stages.a/b", "a/b", "letters"),
    _read("taken-name", "[deviations]", "[bodies.left]\n[deviations]", "bodies.left", "left", "another name"),
    _read("same-name", "[deviations]", "[bodies.main]\n[deviations]", "stages.main", "main", "another name"),
    _read("member-name", "[deviations]", "[stages.main.meshes.sun]\n[deviations]", "meshes.sun", "sun", "joined by -"),
    # stages and members
    _read("unknown-key", SUN, "[stages.main.sun]\ntooth = 24", "stages.main.sun.tooth", "24", "'teeth'"),
    _read("unknown-stage-key", "planets = 3", "planet_count = 3", "stages.main.planet_count", "3", ""),
    _read("unknown-member", SUN, "[stages.main.snu]\nteeth = 24", "stages.main.snu", "", "kind"),
    _read("no-teeth", SUN, "[stages.main.sun]", "stages.main.sun.teeth", "", "number of teeth"),
    _read("negative-teeth", RING, "[stages.main.ring]\nteeth = -72", "stages.main.ring.teeth", "-72", ">= 3"),
    _read("half-teeth", RING, "[stages.main.ring]\nteeth = 72.5", "stages.main.ring.teeth", "72.5", "whole number"),
    _read("teeth-true", RING, "[stages.main.ring]\nteeth = true", "stages.main.ring.teeth", "True", "whole number"),
    _read("teeth-text", RING, '[stages.main.ring]\nteeth = "72"', "stages.main.ring.teeth", "72", "whole number"),
    _read("teeth-huge", RING, "[stages.main.ring]\nteeth = 1000000000", "stages.main.ring.teeth", "1000000000", "<= "),
    _read("no-planets", "planets = 3\n", "", "stages.main.planets", "", "planet_angles"),
    _read("zero-planets", "planets = 3", "planets = 0", "stages.main.planets", "0", ">= 1"),
    _read("two-ways", "planets = 3", "planets = 3\nplanet_angles = [0, 2, 4]", "planet_angles", "", "one of planets"),
    _read("kind-of-name", SUN, '[stages.main.sun]\nkind = "ring"\nteeth = 24', "stages.main.sun.kind", "ring", "sun"),
    _read("unknown-kind", "[stages.main.planet]", '[stages.main.star]\nkind = "star"', "star.kind", "star", '"planet"'),
    _read("hand", SUN, SUN + '\nhand = "up"', "stages.main.sun.hand", "up", '"left" or "right"'),
    _read(
        "key-of-other-kind", SUN_SUPPORT, 'teeth = 24\nbearing.x = "1 N/m"', "stages.main.sun.bearing", "", "support"
    ),
    _read("planet-support", BEARING, 'support.radial = "1 N/m"', "stages.main.planet.support", "", "bearing"),
    _read("carrier-teeth", 'mass = "20 kg"', "teeth = 3", "stages.main.carrier.teeth", "", "one of"),
    _read("on-nothing", PLANET, PLANET + '\non = "plnet2"', "stages.main.planet.on", "plnet2", "member"),
    _read("on-itself", PLANET, PLANET + '\non = "planet"', "stages.main.planet.on", "planet", "sun, ring"),
    _read("clocking-alone", PLANET, PLANET + '\nclocking = "fit"', "stages.main.planet.clocking", "", "on ="),
    _read("split-text", "planets = 3", 'planets = 3\nsplit = "yes"', "stages.main.split", "yes", "true or false"),
    # units
    _read("wrong-unit", '"4 mm"', '"4 kg"', "stages.main.module", "4 kg", "m, mm, um"),
    _read("no-unit", '"4 mm"', '"4"', "stages.main.module", "4", "m, mm, um"),
    _read("no-number", '"4 mm"', '"abc"', "stages.main.module", "abc", "m, mm, um"),
    _read("comma", '"4 mm"', '"4,5 mm"', "stages.main.module", "4,5 mm", "m, mm, um"),
    _read("module-true", '"4 mm"', "true", "stages.main.module", "True", "m, mm, um"),
    _read("module-list", '"4 mm"', '"[4, 5] mm"', "stages.main.module", "[4, 5] mm", "length"),
    _read("module-table", '"4 mm"', "{ normal = 4 }", "stages.main.module", "normal", "length"),
    _read("module-zero", '"4 mm"', "0", "stages.main.module", "0", ">= 1e-05"),
    _read("module-huge", '"4 mm"', '"1e300 m"', "stages.main.module", "1e300 m", "<= 10000 m"),
    _read("module-inf", '"4 mm"', "inf", "stages.main.module", "inf", "<= 10000 m"),
    _read("negative-width", '"40 mm"', '"-40 mm"', "stages.main.face_width", "-40 mm", "> 0"),
    _read("degrees-bare", "planets = 3", "planets = 3\nhelix_angle = 20", "stages.main.helix_angle", "20", "rad, deg"),
    _read("hertz", '"1000 rpm"', '"16.7 Hz"', "operation.speed.main.sun", "16.7 Hz", "rpm"),
    _read("per-second", '"1000 rpm"', '"16.7 1/s"', "operation.speed.main.sun", "16.7 1/s", "revolutions or radians?"),
    _read("torque-in-N", '"1 kN m"', '"1 kN"', "operation.torque.main.sun", "1 kN", '"balance"'),
    _read("inertia-unit", '"0.2 kg m^2"', '"0.2 kg m"', "stages.main.carrier.inertia", "0.2 kg m", "kg mm^2"),
    _read("endless-power", '"4 mm"', '"4 m**9**9**9**9"', "stages.main.module", "m**9", "m, mm, um"),
    # links
    _read(
        "negative-stiffness", SUN_SUPPORT, 'teeth = 24\nsupport.x = "-1 N/m"', "stages.main.sun.support.x", "-1", ">= 0"
    ),
    _read("shorthand-and-long", BEARING, "bearing = { radial = 1, x = 2 }", "planet.bearing.x", "2", "one"),
    _read(
        "support-number", SUN_SUPPORT, 'teeth = 24\nsupport = "1e8 N/m"', "stages.main.sun.support", "1e8", "a table"
    ),
    _read("unknown-direction", BEARING, "bearing = { radail = 1 }", "planet.bearing.radail", "1", "'radial'"),
    _read("named-and-own", BEARING, "bearing = { z = 0, front = { x = inf } }", "planet.bearing", "z", "named bearing"),
    _read(
        "per-planet", BEARING, 'bearing.x = "[1, 2] N/m"', "stages.main.planet.bearing.x", "[1, 2]", "3, one per planet"
    ),
    _read(
        "sun-per-planet",
        SUN_SUPPORT,
        'teeth = 24\nsupport.x = "[1, 2, 3] N/m"',
        "sun.support.x",
        "[1, 2, 3]",
        "one number",
    ),
    _read("half-friction", BEARING, "bearing.friction = { coefficient = 0.1 }", "bearing.friction", "0.1", "radius"),
    _read(
        "friction-law", BEARING, 'bearing.friction = { force = "1 N", law = "dry" }', "friction.law", "dry", '"coulomb"'
    ),
    _read(
        "friction-two-ways",
        BEARING,
        'bearing.friction = { force = "1 N", coefficient = 0.1, radius = "20 mm" }',
        "bearing.friction.radius",
        "",
        "one of force, coefficient, radius",
    ),
    _read("negative-clearance", BEARING, 'bearing.clearance = "-5 um"', "planet.bearing.clearance", "-5 um", ">= 0"),
    _read("exponent-below-one", BEARING, "bearing.exponent = 0.9", "planet.bearing.exponent", "0.9", ">= 1"),
    _read("exponent-without-load", BEARING, "bearing.exponent = 1.1111", "planet.bearing", "1.1111", "load"),
    _read("load-without-exponent", BEARING, 'bearing.load = "5 kN"', "planet.bearing", "5 kN", "exponent"),
    _read("load-zero", BEARING, "bearing = { exponent = 1.1, load = 0 }", "planet.bearing.load", "0", "> 0"),
    _read(
        "friction-and-exponent",
        BEARING,
        'bearing = { exponent = 1.1, load = "3 N", friction.force = "1 N" }',
        "planet.bearing",
        "1.1",
        "one of the two",
    ),
    _read("support-to-nothing", SUN_SUPPORT, 'teeth = 24\nsupport.to = "carier"', "support.to", "carier", "'carrier'"),
    _read("body-without-radius", "[deviations]", '[bodies.g]\nsupport.rz = "1 N/m"\n[deviations]', "rz", "", "N m/rad"),
    _read(
        "body-tilts",
        "[deviations]",
        '[bodies.g]\nsupport.tilt = "1 N m/rad"\n[deviations]',
        "bodies.g.tilt_inertia",
        "",
        "inertia",
    ),
    _read("bolts-nowhere", RING_SUPPORT, _bolts('radius = "1 m"'), "ring.support.bolts", "1 m", "count, or angles"),
    _read("bolts-no-angle", RING_SUPPORT, _bolts("radius = 1, angles = []"), "ring.support.bolts", "", ""),
    _read("bolts-no-radius", RING_SUPPORT, _bolts("count = 6"), "ring.support.bolts.radius", "", ""),
    _read("bolts-none", RING_SUPPORT, _bolts('count = 0, radius = "1 m"'), "ring.support.bolts.count", "0", ">= 1"),
    _read("bolts-half", RING_SUPPORT, _bolts('count = 5.5, radius = "1 m"'), "bolts.count", "5.5", "whole number"),
    _read(
        "bolts-two-ways",
        RING_SUPPORT,
        _bolts('count = 2, angles = "[0, 1] rad", radius = "1 m"'),
        "bolts.angles",
        "",
        "one of",
    ),
    _read("bolts-point", RING_SUPPORT, _bolts('count = 3, radius = "0 mm"'), "bolts.radius", "0 mm", "> 0"),
    _read(
        "bolts-soft", RING_SUPPORT, _bolts('count = 3, radius = "1 m", radial = "-1 N/m"'), "bolts.radial", "-1", ">= 0"
    ),
    _read(
        "bolts-torsion", RING_SUPPORT, _bolts('count = 3, radius = "1 m", z = "1 N m/rad"'), "bolts.z", "N m/rad", "N/m"
    ),
    _read("bolts-unknown", RING_SUPPORT, _bolts('count = 3, radius = "1 m", x = 1'), "bolts.x", "1", ""),
    _read("bolts-number", RING_SUPPORT, "support.bolts = 6", "ring.support.bolts", "6", "a table"),
    _read(
        "bolts-lists",
        RING_SUPPORT,
        _bolts('count = 3, radius = "1 m", z = "[1, 2, 3] N/m"'),
        "bolts.z",
        "[1, 2, 3]",
        "",
    ),
    _read(
        "bolts-of-planet", BEARING, 'bearing.bolts = { count = 3, radius = "1 m" }', "bearing.bolts", "", "couplings"
    ),
    _read(
        "bolts-of-bearing",
        BEARING,
        'bearing.front.bolts = { count = 3, radius = "1 m" }',
        "planet.bearing.front.bolts",
        "",
        "couplings",
    ),
    _read(
        "bolts-of-neck",
        SUN_SUPPORT,
        'teeth = 24\nneck.bolts = { count = 3, radius = "1 m" }',
        "stages.main.sun.neck.bolts",
        "",
        "couplings",
    ),
    _read("body-frame", "[deviations]", '[bodies.g]\nframe = "mian"\n[deviations]', "bodies.g.frame", "mian", "'main'"),
    _read("body-frame-number", "[deviations]", "[bodies.g]\nframe = 1\n[deviations]", "bodies.g.frame", "1", "a text"),
    # meshes
    _read(
        "mesh-of-nothing", "[operation]", "[stages.main.meshes]\nsun-plnt = {}\n[operation]", "sun-plnt", "", "'planet'"
    ),
    _read(
        "mesh-of-carrier",
        "[operation]",
        "[stages.main.meshes]\nsun-carrier = {}\n[operation]",
        "sun-carrier",
        "",
        "sun",
    ),
    _read(
        "mesh-word",
        "[operation]",
        '[stages.main.meshes]\nsun-planet.stiffness = "iso"\n[operation]',
        "stiffness",
        "iso",
        "iso6336",
    ),
    _read(
        "variation",
        "[operation]",
        "[stages.main.meshes]\nsun-planet.variation = {}\n[operation]",
        "variation",
        "{}",
        "cosine",
    ),
    _read("slices-none", "[operation]", f"{SLICES} = 0\n[operation]", "sun-planet.slices", "0", ">= 1"),
    _read("slices-half", "[operation]", f"{SLICES} = 2.5\n[operation]", "sun-planet.slices", "2.5", "whole number"),
    _read("slices-text", "[operation]", f'{SLICES} = "3"\n[operation]', "sun-planet.slices", "3", "whole number"),
    _read("slices-many", "[operation]", f"{SLICES} = 1000\n[operation]", "sun-planet.slices", "1000", "<= 200"),
    _read(
        "slices-of-side", "[operation]", f"{SLICES.replace('.slices', '.left.slices')} = 2\n[operation]", "left", "", ""
    ),
    # couplings, loads
    _read(
        "coupling-radius",
        "[deviations]",
        '[bodies.g]\n[couplings.c]\nbetween = ["sun", "g"]\nrz = "1 N/m"\n[deviations]',
        "couplings.c.rz",
        "",
        "radius",
    ),
    _read(
        "coupling-per-planet",
        "[deviations]",
        '[bodies.g]\n[couplings.c]\nbetween = ["sun", "g"]\nx = "[1, 2, 3] N/m"\n[deviations]',
        "couplings.c.x",
        "[1, 2, 3]",
        "one number",
    ),
    _read(
        "coupling-to-itself",
        "[deviations]",
        '[couplings.c]\nbetween = ["sun", "main.sun"]\n[deviations]',
        "couplings.c.between",
        "main.sun",
        "two members",
    ),
    _read(
        "coupling-of-three",
        "[deviations]",
        '[couplings.c]\nbetween = ["sun", "ring", "carrier"]\n[deviations]',
        "couplings.c.between",
        "main.sun",
        "",
    ),
    _read(
        "coupling-to-nothing",
        "[deviations]",
        '[couplings.c]\nbetween = ["sun", "out"]\n[deviations]',
        "couplings.c.between",
        "out",
        "member",
    ),
    _read("coupling-number", "[deviations]", "[couplings]\nc = 3\n[deviations]", "couplings.c", "3", "a table"),
    _read("load-on-nothing", "[deviations]", '[loads.a]\non = "rotor"\n[deviations]', "loads.a.on", "rotor", "member"),
    # operation
    _read("held-nothing", '["ring"]', '["rng"]', "operation.held", "rng", "'ring'"),
    _read("held-text", '["ring"]', '"ring"', "operation.held", "ring", "a list"),
    _read("held-twice", '["ring"]', '["ring", "main.ring"]', "operation.held", "main.ring", "once"),
    _read("held-and-turning", '["ring"]', '["sun"]', "operation.speed.main.sun", "1000 rpm", "held"),
    _read("speed-of-nothing", "speed.sun", "speed.snu", "operation.speed.main.snu", "1000 rpm", "'sun'"),
    _read("torque-and-power", '"1 kN m"', '"1 kN m"\npower.sun = 3', "operation.power.main.sun", "", "torque"),
    _read(
        "gravity",
        'held = ["ring"]',
        'held = ["ring"]\ngravity = "[0, 9.81] m/s^2"',
        "operation.gravity",
        "[0, 9.81]",
        "list of 3",
    ),
    # deviations
    _read("deviation-of-nothing", "sun.run_out", "star.run_out", "deviations.main.star", "", "sun, planet, ring"),
    _read("deviation-unknown", "sun.run_out", "sun.runout", "deviations.main.sun.runout", "10 um", "'run_out'"),
    _read("phase-alone", '"10 um"', '{ phase = "3 deg" }', "deviations.main.sun.run_out", "3 deg", "amplitude, phase"),
    _read("both-vectors", '"10 um"', "{ amplitude = 1, x = 2 }", "deviations.main.sun.run_out.x", "", "amplitude"),
    _read("pitch-short", '"10 um"', '"10 um"\nsun.pitch = "[0, 1] um"', "deviations.main.sun.pitch", "", "24 teeth"),
    _read("pitch-no-file", '"10 um"', '"10 um"\nsun.pitch = "no.csv"', "deviations.sun.pitch", "no.csv", "CSV"),
    _read(
        "profile-order",
        '"10 um"',
        '"10 um"\nmeshes.sun-planet.profile = {amplitude = "1 um", order = 0}',
        "order",
        "0",
        ">= 1",
    ),
    _read("error-turns-with", '"10 um"', f'"10 um"\n{ERROR} = {{turns_with = "ring"}}', "mine.amplitude", "", ""),
    _read(
        "error-of-another-mesh",
        '"10 um"',
        f'"10 um"\n{ERROR} = {{turns_with = "ring", amplitude = "1 um"}}',
        "deviations.main.meshes.sun-planet.errors.mine.turns_with",
        "main.ring",
        "main.sun, main.planet",
    ),
    _read(
        "error-sense",
        '"10 um"',
        f'"10 um"\n{ERROR} = {{turns_with = "sun", amplitude = "1 um", sense = "up"}}',
        "errors.mine.sense",
        "up",
        "closes",
    ),
    # assumed, tolerance
    _read(
        "assumed-nothing",
        "[deviations]",
        '[assumed]\n"stages.main.modul" = "x"\n[deviations]',
        "assumed.stages.main.modul",
        "x",
        "'stages.main.module'",
    ),
    _read(
        "tolerance-text",
        "[deviations]",
        '[tolerance]\n"stages.main.module" = "3 mm"\n[deviations]',
        "tolerance",
        "3 mm",
        "normal",
    ),
    _read(
        "tolerance-nothing",
        "[deviations]",
        '[tolerance]\n"deviations.sun.position.q" = "normal(0, 1 um)"\n[deviations]',
        "position.q",
        "normal",
        "a path",
    ),
    _toleranced("tolerance-unknown", '"deviations.sun.run_out" = "gamma(1, 2)"', "sun.run_out", "gamma", "normal(mean"),
    _toleranced(
        "tolerance-spread", '"deviations.sun.run_out" = "normal(0, -1 um)"', "sun.run_out", "-1 um", "deviation >= 0"
    ),
    _toleranced("tolerance-dimension", '"deviations.sun.run_out" = "disc(1 kg)"', "sun.run_out", "1 kg", "length"),
    _toleranced("tolerance-count", '"stages.main.sun.teeth" = "uniform(20, 30)"', "sun.teeth", "uniform", "varies"),
    _toleranced(
        "tolerance-of-no-error",
        '"deviations.meshes.sun-planet.errors.mine.amplitude" = "normal(0, 1 um)"',
        "errors.mine.amplitude",
        "normal",
        "a path",
    ),
    _toleranced(
        "tolerance-phase", '"deviations.planet.run_out" = { own = "disc(1 um)", phase = 3 }', "phase", "3", "marked"
    ),
    _toleranced("tolerance-common", '"deviations.sun.run_out" = { common = "disc(1 um)" }', "common", "disc", "own"),
    _toleranced(
        "tolerance-twice",
        '"deviations.sun.run_out" = "disc(1 um)"\n"deviations.main.sun.run_out.x" = "normal(0, 1 um)"',
        "sun.run_out.x",
        "",
        "one of the two",
    ),
    _toleranced(
        "tolerance-price",
        '"deviations.sun.run_out" = "disc(1 um)"\ncost."deviations.sun.run_out" = { "disc(1 um)" = "4 EUR" }',
        "tolerance.cost",
        "4 EUR",
        "currency",
    ),
    # what only geometry, kinematics and statics find
    _resolve(
        "two-balances",
        '"1 kN m"',
        '"balance"\ntorque.carrier = "balance"\ntorque.planet = "1 N m"',
        "operation.torque.main.carrier",
        "balance",
        "one balance",
    ),
    _resolve(
        "tolerance-grade",
        "[deviations]",
        '[tolerance]\n"deviations.sun.run_out" = "grade(IT6, 3 sigma)"\n[deviations]',
        "tolerance.deviations.main.sun.run_out",
        "grade(IT6",
        "position of a planet",
    ),
    _resolve(
        "tolerance-correlation",
        "[deviations]",
        '[tolerance.deviations.sun.position]\nx = "normal(0, 1 um)"\ny = "normal(0, 1 um)"\n[tolerance]\n'
        'correlation."deviations.sun.position.x" = { "deviations.sun.position.y" = 0.9999999 }\n[deviations]',
        "tolerance.correlation",
        "",
        "smaller ones",
    ),
    _resolve("no-module", 'module = "4 mm"\n', "", "stages.main.sun.module", "", "module"),
    _resolve(
        "module-of-chain",
        SUN_TO_PLANET,
        _both('module = "5 mm"', 'module = "6 mm"'),
        "stages.main.planet.module",
        "",
        "",
    ),
    _resolve(
        "hand-of-chain",
        SUN_TO_PLANET,
        _both('hand = "left"', 'hand = "left"\nhelix_angle = "9 deg"'),
        "stages.main",
        "left",
        "",
    ),
    _resolve("planets-collide", "planets = 3", "planets = 8", "stages.main.planet", "", ""),
    _resolve(
        "planets-at-one-place", "planets = 3", 'planet_angles = "[0, 0, 120] deg"', "stages.main.planet_angles", "", ""
    ),
    _resolve("ring-too-small", RING, "[stages.main.ring]\nteeth = 40", "stages.main", "", ""),
    _resolve("centre-distance", "planets = 3", 'planets = 3\ncentre_distance = "60 mm"', "centre_distance", "", ""),
    _resolve(
        "meshes-with-nothing",
        "[operation]",
        '[stages.main.idle]\nkind = "gear"\nteeth = 30\n[operation]',
        "stages.main",
        "",
        "",
    ),
    _resolve(
        "two-free-ends",
        "[operation]",
        '[stages.main.other]\nkind = "sun"\nteeth = 24\n[operation]',
        "operation.torque",
        "",
        '"balance" at one of main.carrier, main.other',
    ),
    _resolve(
        "halves-in-the-air", "planets = 3", "planets = 3\nherringbone = true\nsplit = true", "stages.main", "", "neck"
    ),
    _resolve("too-many-speeds", '"1000 rpm"', '"1000 rpm"\nspeed.carrier = "3 rpm"', "operation.speed", "", ""),
    _resolve("torque-cannot-balance", '["ring"]', '["ring"]\ntorque.carrier = "5 N m"', "operation.torque", "", ""),
    _resolve(
        "slices-without-width",
        'face_width = "40 mm"\n',
        """meshes.sun-planet = { stiffness = "1e9 N/m", slices = 3 }
meshes.planet-ring = { stiffness = "1e9 N/m" }
""",
        "stages.main.face_width",
        "slices = 3",
        "",
    ),
    _resolve("bore-too-wide", SUN, SUN + '\nbore = "96 mm"', "stages.main.sun.bore", "", ""),
)

# files that are no text in TOML at all: name, bytes, word of the message
BYTES: tuple[tuple[str, bytes, str], ...] = (
    ("empty", b"", "empty"),
    ("blank", b" \n\t\n", "empty"),
    ("binary", bytes(range(256)) * 8, "binary"),
    ("zip", b"PK\x03\x04\x14\x00\x00\x00", "binary"),
    ("latin-1", BASE.replace("planetary", "planet\xe9").encode("latin-1"), "line 2"),
    ("utf-16", BASE.encode("utf-16"), "binary"),
    ("csv", b"a,b\n1,2\n", "line 1"),
    ("json", b'{"format": 2}', "line 1"),
    ("too-large", b"#" * 5_000_000, "4000000 bytes"),
)
