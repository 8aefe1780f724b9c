"""The process of the films as printed: a tone curve that knows how much resin, or does not."""

from mpfcad.film import Groove

GROOVE = Groove(0.05, 0.025)
#: `{0}`: deviation of ln(transfer factor).
CALIBRATION = """
schema = 1
kind = "tone"
source = "coupons of a test"
[tone]
transfer_factor = 0.5
dead_zone = 0.0
contrast = 1.0
gain = 1.0
deviation = [{0}, 0.0, 0.0, 0.0]
correlation = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
[screen]
volume_cm3_m2 = 20.0
"""
