"""The commented job that `mpfcad init` writes; it is itself a valid job."""

#: The name in it, which the file's own takes the place of.
TEMPLATE_NAME = "my-film"

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
# series_per_mm = [[60, 1], [1.5, 0]]  # under LEDs, instead of a file: cosines over their cell

# [crossed]                     # under LEDs: the film across is printed too, with the same C
# [halftone]                    # under LEDs: pieces of grooves, bare or printed alike: docs/led.md
# curvature_per_mm = 60.0       # C of the printed ones
# piece_mm = 4.0                # how long they are, and how many grooves wide
# grooves = 8

[film]
profile = "filled"              # resin in a BEF, printable for C <= 80 /mm; "ideal": a mould only
pitch_um = 50.0                 # of pitch_um, depth_um and prism_angle_deg (90) give two:
depth_um = 25.0                 # the third follows
base_um = 200.0                 # thickness below the valleys
# refractive_index = 1.55       # of the prisms; the stack's when left out
# How the film is really made, with the resin that the mask gives: see docs/cad.md
# tip_radius_um = 1.0           # rounded tips, and valleys of the bare prisms
# valley_radius_um = 1.0
# prism_angle_error_deg = -0.5
# pitch_error_um = 0.01
# measured_file = "trace.csv"   # a stylus trace in the parabola's place
# surface = "arc"               # of the resin: at process.contact_angle_deg; or "level"
# resin_spread_percent = 3.0    # of the resin from groove to groove
# cell = "pyramid"              # or "paraboloid": cells in both directions instead of grooves

[process]                       # aperture ratio <-> fill fraction (docs/process.md)
solids_fraction = 0.5           # of the resin as printed; 1: no solvent
# calibration = "process.toml"  # what `mpfcad calibrate` made of your step wedge; until then
# model = "prior"               # mesh's volume and a published tone curve; "linear", "thesis"
# viscosity_pa_s = 0.4          # of the resin, wet; these four replace mask.levelling_length_mm
# surface_tension_mn_m = 30.0
# contact_angle_deg = 10.0      # below 45, or it does not run along the grooves
# time_to_uv_s = 10.0           # from print to UV

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
registration_um = 200.0         # by which a print may be shifted across
# angle_deg = 22.5              # of an angled lattice
# dot_um = 30.0                 # of a stochastic pattern; the largest that leaves the web
# pixel_um = 363.0              # of the display, for the moiré

[mask.mesh]                     # of the screen (docs/mask.md); without it: phototool only
name = "150-31"                 # or "auto"; or threads_per_cm, thread_um and, from the weaver,
                                # opening_um, thickness_um, material = "steel"
# catalogue = "weaver.csv"      # a table of meshes that the name is looked up in
emulsion_um = 0.0               # over mesh
angle_deg = 22.5                # of the threads to the grooves
# release = 0.65                # share of its volume that leaves it; assumed when left out

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
# levels = 64                   # under LEDs: curvatures of the library, and length of its pieces
# piece_mm = 0.5
stl = "whole"                   # `mpfcad cad`: one film.stl, or "tiles" of one lamp pitch each

[stack]
preset = "thesis-32in-mpf"      # `mpfcad stacks` lists them; or file = "my-stack.toml"
# thickness_mm = 20.0           # reflector to plate; the preset's own when left out

[stack.override]                # single values of the stack, by the names `mpfcad stacks` shows

[gates]                         # lamp-Mura contrast (Lmax - Lmin)/(Lmax + Lmin); then the screen's
contrast_pass = 0.012           # PASS up to here
contrast_marginal = 0.018       # MARGINAL up to here, FAIL above
ratio_min = 0.1                 # printable band of aperture ratios
ratio_max = 0.85
ripple_curvature_per_mm = 0.5   # after levelling, root mean square along the worst groove
ripple_luminance = 0.005        # what the picture sees of it
registration_curvature_per_mm = 1.0

[trace]
effort = "standard"             # "quick": under two minutes; "final": the narrowest interval
"""
