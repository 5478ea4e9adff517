"""Codes of the physical warnings: every warning of a result ends with one in brackets, and the table here explains it.

A text becomes a warning by `coded` alone: `CodedText` is what every list of warnings holds, so that the type checker
finds a text without a code.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NewType

CodedText = NewType("CodedText", str)
"""Text of a warning that ends with its code in brackets."""

_CODE = re.compile(r" \[([a-z0-9-]+)\]$")


@dataclass(frozen=True, slots=True)
class WarningCode:
    """What a warning means, what cures it, and the page of the documentation that says more (a file name)."""

    meaning: str
    cure: str
    page: str


def coded(code: str, text: str) -> CodedText:
    """Return a warning: the text with its code in brackets behind it.

    Raises KeyError for a code that `WARNING_CODES` has not.
    """
    if code not in WARNING_CODES:
        raise KeyError(code)
    return CodedText(f"{text} [{code}]")


def placed(where: str, text: CodedText) -> CodedText:
    """Return a warning with the place it is about before it; its code stays behind."""
    return CodedText(f"{where}: {text}")


def code_of(text: str) -> str | None:
    """Return the code of a warning; None of a text that has none, of a result of an earlier version."""
    found = _CODE.search(text)
    return found[1] if found and found[1] in WARNING_CODES else None


def _table(rows: str) -> dict[str, WarningCode]:
    """Return the table of blocks of four lines: code and page, meaning, cure."""
    table = {}
    for block in rows.strip().split("\n\n"):
        (code, page), meaning, cure = block.split("\n")[0].split(), *block.split("\n")[1:]
        table[code] = WarningCode(meaning=meaning.strip(), cure=cure.strip(), page=page)
    return table


WARNING_CODES: Mapping[str, WarningCode] = _table(
    """
teeth-changed model-file.md
An override changes teeth of a file that states radii or masses of these gears: they are scaled with the teeth.
Set the radii and masses beside the teeth, or remove them (an empty value) to have them derived.

ring-teeth model-file.md
With other teeth on sun or planet the ring fits no longer: sun and two planets make another number.
Set the teeth of the ring too, or profile shifts with a centre distance.

rexs-assumed rexs.md
The model is a REXS file: what it does not say is assumed, and what the model has no place for is dropped.
Read the list that `epicyclic import FILE` prints; with -o it writes the model file, in which values can be replaced.

rexs-stages-unread rexs.md
Gear stages without planets, as parallel ones, are not read from a REXS file: the train ends before them.
Import with -o and add these stages and their couplings to the model file: a stage table of two gears without planets.

contact-ratio-below-one teeth.md
The transverse contact ratio is below 1: one pair of teeth parts before the next one meets.
Longer addenda, another profile shift or more teeth; check centre distance and tip diameters.

centre-distances-differ model-file.md
Stated or derived centre distances of the meshes of one stage fit no single place of the axes.
Correct centre distance, profile shifts or base radii, so that all meshes of the planet give one distance.

base-radius-far model-file.md
A stated base radius is far from that of teeth, module and angles; it is kept, and a torque may not balance on it.
Correct base_radius, module or teeth; without base_radius it follows from the teeth.

base-radius-scaled model-file.md
Under a torque, stated base radii within 0.5 % of the ratios of the teeth, as rounded print is, give way to exact ones.
State base_radius in the ratio of the teeth, or leave it out; without a torque radii stay as stated.

not-assembled model-file.md
At the planet angles given the teeth do not meet: the stage cannot be assembled.
Use the nearest angles that the warning names (planet_angles), or tooth numbers that fit equal spacing.

shafts-not-alike model-file.md
Identical stepped shafts do not fit all branches: their gears need another clocking on each.
Give clocking per branch, or choose tooth numbers that let one shaft fit everywhere.

ring-too-small model-file.md
The planet does not fit into its ring by the radii of their teeth.
Check the teeth of ring and planet and the radii stated.

gears-overlap model-file.md
Tip circles of two gears overlap that do not mesh, unless they stand in different planes.
State the station and the face width of each where they stand apart along the axis, else other teeth.

planets-collide model-file.md
Tip circles of neighbouring planets overlap.
Fewer or smaller planets, or other planet angles.

tips-in-roots teeth.md
Tips of one gear reach into the root circle of its mate.
A shorter addendum, a deeper dedendum of the mate, or another profile shift.

tips-below-involute teeth.md
Tips reach below the involute of their mate by a little; the fillet is taken as involute there.
A shorter tip, or another profile shift.

thin-rim model-file.md
The rim of a ring is thin: it bends between the planets, which a rigid body cannot show.
A ring that bends (elastic = true); or a thicker rim (rim, outer_diameter).

thick-ring elastic-rings.md
The rim of a ring that bends is higher than a curved beam is right for.
A ring without elastic where it is stiff enough; else take its bending as an estimate.

ring-orders elastic-rings.md
Orders of a ring that are left out have natural frequencies near the mesh frequency.
More modes in the table elastic.

rim-in-stiffness elastic-rings.md
A gear bends by coordinates of its own, and the stiffness of its meshes is of a kind that may hold that bending too.
Of a ring with elastic, stiffness = "energy" or "contact", which leave its orders out; or a number of stiff bodies.

reduced-mass-off reduced-bodies.md
Mass, centre or inertia of a reduced body differ a little from those that its file says to expect.
The file of the finite-element program; units and added masses there.

mean-motion-held reduced-bodies.md
A support or shaft joins a reduced body on its axis, where the body has no interface: it acts on the mean motion.
An interface of the nodes that the support or shaft takes hold of.

bolts-off-ring elastic-rings.md
Bolts stand on a circle far from the ring that they hold; the motion of its section is taken out to there.
The radius of the circle; or a table radius of the ring.

bolts-averaged elastic-rings.md
Bolts, or a body in another frame, pass a ring that bends: a tone of response, stability, transient; else their mean.
More bolts than twice the orders of the ring, evenly spaced; else read lateral motions off the response.

strain-without-stretch sensors.md
A strain gauge sits on a ring that does not stretch: its strain is that of bending alone.
State axial = true in the table elastic of the ring.

tilt-without-slices model-file.md
A mesh of one row has no stiffness against tilt although its gears may tilt against each other.
Leave slices out or set it above 1, and state face_width.

shaft-span-resonates model-file.md
A shaft between two places has a bending mode of its own near the mesh frequency, which its ends do not show.
Name one more support with radial = 0 in the middle of the span, behind the others: its place gets mass of its own.

deviation-large model-file.md
A deviation is more than a tenth of a module.
Check its unit: most deviations are in um.

modification-large model-file.md
An amount of relief, crown or slope is more than a tenth of a module.
Check its unit: modifications are in um.

flank-without-effect relief.md
A pair has micro-geometry (relief, crown, slope, profile) and a mesh stiffness that does not know it.
State stiffness = "contact" of the mesh; without it only contact and relief count the flanks.

deviation-without-speed model-file.md
Deviations that turn with a body are left out: without speeds their frequency is not known.
State operation.speed of one member.

ripple-without-speed model-file.md
Ripple of torque or motion is left out: nothing turns, so its frequency is not known.
State operation.speed of one member, or remove the ripple.

ripple-without-inertia ripple.md
A torque ripple acts on a shaft whose machine has no inertia in the model: it shakes the gear alone, far too much.
State the inertia of the machine, as a body of its own behind a coupling or in the inertia of the member.

ripple-mean ripple.md
The mean of a table of torques over a turn is not the torque of the operation there, which counts.
State the same mean in operation.torque, or take the mean out of the table.

deviation-without-effect model-file.md
A deviation moves nothing: no mesh, pin, support or bearing transmits it.
Correct its path, or state the support or bearing that it displaces.

stiffness-unusual teeth.md
A mesh stiffness per face width is outside the range of teeth of these materials (steel where no modulus is given).
Check the unit of the stiffness, the face width and the material of both gears.

formula-outside-limits teeth.md
A formula is used outside the range that its source states.
Another stiffness method (stiffness = "energy" or "loaded-contact"), or take the result as an estimate.

no-torque contact-loss.md
No torque presses the teeth together: with contact loss they lie apart, or only vibration makes them meet.
State operation.torque or operation.power; transient shows how unloaded teeth rattle.

tangent-load-assumed laws.md
No torque passes a mesh whose stiffness depends on load: its tangent is taken at an assumed load.
State operation.torque, or load beside the table.

table-exceeded laws.md
A force passes the last one of its table; the law goes on along its last tangent there.
Extend the table to the forces met.

friction-without-clearance laws.md
Friction of a link has no clearance to slide in and does nothing.
State clearance of the link, or remove friction.

far-flank-linear laws.md
The far flank of a mesh is a linear spring: slope, waves and pitch deviations are of the loaded flank alone.
Nothing to do while the loaded flank carries; where teeth strike back their far flank is an estimate.

power-circulates efficiency.md
Power circulates on a closed path through members and adds to what the meshes carry.
Check meshes and bearings against the circulating power, or another arrangement of the stages.

not-solvable model-file.md
The equations of the train cannot be written: the message says what is missing.
State what the message names.

load-not-held model-file.md
The operating load works along a motion that no stiffness holds.
Give one of the members a support or bearing in that direction, or leave the direction out.

no-tooth-contact contact.md
Loaded tooth contact of a pair cannot be computed; other verbs do not need it.
Change what the message names; where it is not needed, nothing.

law-linearised laws.md
A law of gaps (clearance, spline, table) is replaced by its tangent at the mean load in linear verbs.
For the law itself: static, sharing --method static, sweep --contact-loss, transient.

law-over-turn laws.md
A link opens, closes or turns its load over the turn; its tangent at the mean load misses that by what the text says.
For the law itself: static, steady --contact-loss, sweep --contact-loss, transient.

floats-in-clearance laws.md
No link moves at the mean load: bodies float in their clearance.
Nothing where the clearance is meant; else state a support.

position-not-unique sharing.md
No support holds a body: its place is not unique, the mesh forces are.
Nothing to do for forces; for displacements state a support, however soft.

followed-in-time ripple.md
Ripple parts teeth, and no torus of its phases was solved: the forces are those of a run in time.
Nothing; its extremes are those of the run, and residual tells how far its RMS has settled.

teeth-rattle ripple.md
The mean load of a mesh is below the ripple of its force: the teeth part and hammer, on both flanks where they reach.
More mean load (a drag torque), less ripple (a softer coupling, more flywheel), or less backlash.

thrust-not-counted life.md
A rolling bearing without contact angle is held rigidly along the axis or in tilt, and helical teeth load it there.
Two rows, two named bearings at their places, a contact angle, or a bearing of its own for the thrust.

rows-beside-gear life.md
The outer rows of the bearing of a planet stand beside its gear.
Check row_distance, rows and face_width; nothing, where a hub or another gear of the shaft is as wide.

bearing-preloaded life.md
Fits and temperature take more than the clearance of the new bearing: its elements are pressed without load.
A larger clearance group, looser fits, or a smaller temperature difference; nothing, where a preload is meant.

bearing-overloaded life.md
A bearing does not carry its forces: one row with a contact angle carries thrust in one sense.
Turn the contact angle about, take two rows, or a second bearing that carries the other sense.

races-dented life.md
The static safety of a bearing is below 1: its most loaded element leaves a dent of 1e-4 of its diameter.
A larger bearing, more or longer elements, less load.

races-stand life.md
A bearing is loaded while its races do not turn against each other: a rating life is not defined.
Look at false brinelling: small motions, lubrication, or a bearing that turns.

contact-lost contact-loss.md
Teeth lose contact for a part of the time: the mesh force is zero there, and the next impact is harder.
More mean load, less deviation or relief nearer to the load; see run-up and coast-down with sweep --contact-loss.

tension-in-teeth contact-loss.md
The linear model pulls on teeth: they would separate, and the result is not valid there.
sweep --contact-loss, steady --contact-loss, transient or sharing --method static let them part.

far-flank-loaded sharing.md
A mesh rests on its far flank, where its force is negative: the load there has the other sense.
Less deviation or float, more load, or more backlash.

zero-at-loaded-flank sharing.md
Displacements count from first touch of the flanks that this sense of the torque loads, not from the middle of the play.
To compare both senses, add half of the play at the member to each, or turn the load alone: see the page.

mesh-without-load sharing.md
A mesh carries no load in the mean: no load sharing and no dynamic factor K_v is defined there.
Nothing if it idles by design; else check operation.torque and operation.held.

load-sharing-undefined sharing.md
The forces of a group of meshes sum to nothing or less where one carries nothing: the coefficient is infinite.
More load; or sharing --method static, where the teeth part.

mean-load-unknown sharing.md
The coefficients of the mean load (K_gamma) are not known: the train has no equilibrium at rest.
Support what the message names, or read the coefficients of the vibration alone.

force-bound-unknown sharing.md
The largest mesh force over all relative phases is not known for some meshes.
A whole record (all cycles of the common period), or the largest force of the record.

short-record sharing.md
The record is shorter than the period after which the same teeth meet again: its extremes may be exceeded.
More cycles (--cycles, --turns); coefficients that cover all phases need none.

no-damping transient.md
Nothing is damped: what a start or a step sets moving never dies away.
State damping.modal, or damping of meshes and supports.

torque-undetermined cases.md
Couplings close a path of their own, as two clutches between the same members do: their stiffnesses share the load.
Open one of them, or take the torques of `static`.

no-backlash transient.md
No backlash is given where teeth part, or where a train is locked: the far flanks are taken as never touching.
State backlash of the mesh.

motion-unbounded transient.md
The motion in time grows without bound.
A shorter step; if it still grows, the train is unstable at this speed.

slow-law transient.md
A law has no compiled form: the run is integrated with NumPy, some 30 times slower.
A shorter run, or a law with a compiled form.

frequencies-rounded modes.md
Natural frequencies are so far apart that rounding shows in the lowest ones.
Replace a very large stiffness by inf (rigid), or leave the lowest frequencies unread.

shapes-changed compare.md
Mode shapes of two trains differ so much that the pairs of their natural frequencies are doubtful.
Compare smaller steps, or follow the modes along the parameter with the verb track.

mode-grows modes.md
A mode grows at this speed: the rotating train is unstable.
A stiffer support, a lower speed, or damping.

cases-not-weighed cases.md
Some load cases have a duration or a share of the time and others none: nothing is weighed by the time.
A duration, or a share, in every case; 0 where it takes none.

no-steady-motion response.md
Centripetal terms exceed the stiffness at these speeds: no steady motion exists, the values are nan.
A lower speed, or a stiffer support of the body that the message names.

motion-unstable stability.md
The periodic motion is not stable (Floquet): no train stays on it.
Look for what takes its place with sweep --contact-loss or transient; more damping stabilises.

stability-unknown stability.md
The Floquet multipliers of a motion or speed are not known, or the largest one is within its error of 1.
Read the reason in status; a neighbouring speed, or more steps.

no-motion-found contact-loss.md
No periodic motion was found at some points of a sweep.
A finer or shorter range of speed; with linear contact more damping; transient shows the motion in time.

several-motions contact-loss.md
A run-up or coast-down has fallen from the end of a branch to where several motions are stable: it is on one of them.
Compare both directions, path_force_rms and a run with other speeds; transient with a slow ramp decides one case.

branch-ended contact-loss.md
A branch of motions ended before it was through: motions beyond it may be missing.
Another range of speed, or more points.

branch-cut contact-loss.md
A branch that winds through unstable motions was cut: unstable motions may be missing, stable ones are not meant.
Nothing for run-up and coast-down; a narrower range shows more of it.

shaft-orders-left-out contact-shaft-orders.md
Run-outs and other shaft orders are left out of this sweep.
The option for shaft orders includes them, at a price in time.

shaft-orders-failed contact-shaft-orders.md
With shaft orders nothing is known at some points of the sweep.
Read the reason in status; steady --contact-loss at that speed tries harder, transient and static need no such orders.

rows-dropped contact-shaft-orders.md
Harmonics and combinations left out carry a notable share of the motion: forces at an instant have about that error.
Nothing for RMS values; transient for the largest force.

lines-superposed contact-shaft-orders.md
Shaft lines are superposed linearly on flanks that part or bend, with the error stated.
More shaft tones, or transient.

window-cut modulation.md
The window of a sensor is cut at its last harmonic.
More harmonics, or a wider window.

transfer-range modulation.md
The transfer path is given over a smaller range of frequency than the lines: those outside are left out.
Extend the table of the transfer path.

self-locking efficiency.md
Friction in the meshes takes more than the driving power: the train does not turn from that side.
Drive from the other side, a smaller ratio, or less friction.

torques-released efficiency.md
Torques stated balance without losses only; with losses those named follow.
State one torque less.

loop-torques-open efficiency.md
The balance leaves torques of a closed loop open: those nearest to the train without losses are taken.
State a torque within the loop.

friction-outside-limits efficiency.md
Friction by oil is used outside the load or speed it is meant for.
Give the coefficient of friction as a number.

friction-without-history contact.md
Friction of splines has no history in this analysis: they follow their first pull.
static and sharing --method static keep the history.

errors-not-given contact.md
Deviations are asked for, but the file has none of this mesh, or no speeds.
State pitch or profile deviations and operation.speed.

resolution-insufficient contact.md
Phases, instants or slices are not enough for the tolerance asked.
More samples or slices, or a larger tolerance.

contact-not-solved contact.md
Loaded contact is not solved at some phases of the mesh cycle.
Smaller modifications or errors, or another load.

corner-contact contact.md
A tip edge would bear on its mate beyond the path of contact.
Relieve the tips (flank.tip_relief), or the option corner.

at-bound relief.md
The best answer ends at a bound of its search range: a better one may lie beyond.
Widen the range of that variable, if the drawing allows.

search-stopped relief.md
A search ended before it was through: the answer is the best so far.
Continue it (--resume), or allow more generations or combinations.

tolerance-of-another-case cases.md
A tolerance is of a torque of the nominal operation, or of another case, and the case that is computed states its own.
Give a tolerance at the path in the case, `cases.NAME.torque.MEMBER`.

tolerance-without-effect tolerance.md
A tolerance moves K_gamma by nothing: its spread is zero, or nothing that it moves loads a mesh in the mean.
Nothing if it is meant; else correct its path (tangential: position.y) or state the support that it displaces.

points-rounded tolerance.md
The number of samples is rounded up to what the sampler needs.
Nothing; or ask for a power of two.

turning-searched tolerance.md
The largest load while turning of samples whose contact opens is searched for, and may be low by the share stated.
Add that share to mean-load-turning; or read mean-load, which is averaged.

points-failed study.md
Some points or samples could not be computed and count nowhere.
Read their status and reason; narrow the range that fails.

case-failed cases.md
A load case could not be computed; the others are.
Read its reason: a speed or torque too few or too many, or a coupling that is open.

more-warnings study.md
More different warnings of single points than are told.
Run the verb at one point for all of its warnings.

grades-not-monotone tolerance.md
A finer grade has the larger K_gamma in some comparisons: the order of grades is not that of their effect.
More samples; or a spread in place of the grade.

target-missed tolerance.md
The verification with fresh samples reaches more than the target.
A lower target in the search, or more samples.

target-tightened tolerance.md
The search had a lower target, so that the verification with fresh samples meets the one asked for.
Nothing; more samples bring both closer together.

section-left-out model-file.md
An analysis of the report is left out: the message says what the model lacks or what failed.
State what the message names.

audit-differs audit.md
A published number is contradicted, or a row of an audit is wrong or not computed.
Read the row: our number, the published one, the reading and the reason.
"""
)
"""Code -> `WarningCode`, sorted as a reader meets them: model file, drawing, statics, vibration, studies."""
