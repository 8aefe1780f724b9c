"""The layers of a mask: what is on each of them, by its number (datatype 0)."""

APERTURE, OUTLINE, FIDUCIAL, TEXT, COUPON = 1, 2, 10, 11, 20
LAYERS = {
    APERTURE: "aperture",
    OUTLINE: "outline",
    FIDUCIAL: "fiducial",
    TEXT: "text",
    COUPON: "coupon",
}
