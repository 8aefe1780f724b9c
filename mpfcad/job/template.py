"""The commented job that `mpfcad init` writes; it is itself a valid job."""

TEMPLATE = """\
# A job of mpfcad: mpfcad run THIS.toml
# Only name and [map] must be given; everything else shows its default.
schema = 1
name = "my-film"                # the results go to exports/my-film/
seed = 1                        # of the ray trace; the same seed gives the same numbers

[map]                           # the curvature C through the tips of the prisms
curvature_per_mm = 60.0         # one curvature everywhere, or a file (relative to this one):
# file = "my-film.csv"          # columns position_mm,curvature_per_mm; or .npz with those arrays
# extent = "pitch"              # "pitch": the file spans one lamp pitch, 0 above a lamp; "panel"
# repeat = "repeat"             # "mirror": the file spans half a pitch and is mirrored

[film]
profile = "filled"              # resin in a BEF, printable for C <= 80 /mm; "ideal": a mould only
pitch_um = 50.0                 # of pitch_um, depth_um and prism_angle_deg (90) give two:
depth_um = 25.0                 # the third follows
base_um = 200.0                 # thickness below the valleys
# refractive_index = 1.55       # of prism and resin; the stack's when left out
# How the film is really made, with the resin that the mask gives: see docs/cad.md
# tip_radius_um = 1.0           # rounded tips, and valleys of the bare prisms
# valley_radius_um = 1.0
# prism_angle_error_deg = -0.5
# pitch_error_um = 0.01
# measured_file = "trace.csv"   # a stylus trace in the parabola's place
# cell = "pyramid"              # or "paraboloid": cells in both directions instead of grooves

[process]                       # aperture ratio <-> fill fraction
# calibration = "process.toml"  # replaces the built-in one (docs/process.md)

[mask]
pattern = "slot"                # slots across the grooves; dots: "dot" (square), "staggered",
                                # "angled", "blue-noise", "error-diffused" (period 50)
period_um = 400.0               # along the grooves
min_aperture_um = 15.0
min_web_um = 15.0
formats = ["oas", "gds"]        # also "dxf", "gbr", "svg", "tif" (docs/mask-files.md)
polarity = "open"               # what is drawn; or "closed"
mirror = false                  # true: as seen from the film's side
emulsion_side = "film"          # or "squeegee"
furniture = ["fiducial", "text", "coupon"]
levelling_length_mm = 1.0       # over which the resin levels along a groove
# angle_deg = 22.5              # of an angled lattice
# dot_um = 30.0                 # of a stochastic pattern; the largest that leaves the web
# pixel_um = 363.0              # of the display, for the moiré
# [mask.mesh]                   # of the screen (docs/mask.md): adds the mesh's own limits
# name = "120-34"               # or threads_per_cm = 120.0 and thread_um = 34.0
# release = 0.7                 # share of its volume that leaves it; replaces the calibration

[cad]                           # what film.step and film.stl cover; the mask covers the panel
extent = "pitch"                # one lamp pitch, or "panel"
length_mm = 2.0                 # along the grooves, when extent = "pitch"
angle_tolerance_deg = 0.5       # of the facets of film.stl
bodies = "separate"             # film.step: prism and resin apart, or "fused" into one body
# width_mm = 5.0                # of a map C(x, y) only: a window, its lower left corner at
# start_across_mm = 100.0       # the tip nearest to this place on the panel
# start_along_mm = 200.0
# sample_across_um = 2.5        # `mpfcad cad --format tif,dat`: points of the height map
# sample_along_um = 50.0
stl = "whole"                   # `mpfcad cad`: one film.stl, or "tiles" of one lamp pitch each

[stack]
preset = "thesis-32in-mpf"      # `mpfcad stacks` lists them; or file = "my-stack.toml"
# thickness_mm = 20.0           # reflector to plate; the preset's own when left out

[stack.override]                # single values of the stack, by the names `mpfcad stacks` shows

[gates]                         # lamp-Mura contrast (Lmax - Lmin)/(Lmax + Lmin)
contrast_pass = 0.012           # PASS up to here
contrast_marginal = 0.018       # MARGINAL up to here, FAIL above

[trace]
effort = "standard"             # "quick": under two minutes; "final": the narrowest interval
"""
