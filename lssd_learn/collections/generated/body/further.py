"""What else of a body may change by itself: plain data. People vary in more than their build says, and a reader that
knows but few ways of that takes what it does not know for others of its own.

Each is a local change of anny's, of both sides where it has two; what is of the face alone, or leans to a side, is left
out.
"""

# Name of a slider → its local changes.
FURTHER_CHANGES = {
    name: tuple(f"{side}{name}" for side in sides)
    for sides, names in (
        (
            ("",),
            """
            breast-dist-incr breast-point-incr breast-trans-up breast-volume-vert-up buttocks-volume-incr
            chin-jaw-drop-incr head-age-incr head-back-scale-depth-incr head-fat-incr head-scale-depth-incr
            head-scale-horiz-incr head-scale-vert-incr head-trans-forward
            hip-scale-depth-incr hip-scale-horiz-incr hip-scale-vert-incr hip-trans-forward hip-trans-up hip-waist-up
            lowerlegs-height-incr upperlegs-height-incr
            measure-ankle-circ-incr measure-frontchest-dist-incr measure-knee-circ-incr measure-lowerarm-length-incr
            measure-lowerleg-height-incr measure-napetowaist-dist-incr measure-neck-circ-incr
            measure-neck-height-incr measure-shoulder-dist-incr measure-underbust-circ-incr
            measure-upperarm-length-incr measure-waisttohip-dist-incr measure-wrist-circ-incr
            neck-back-scale-depth-incr neck-double-incr neck-scale-depth-incr neck-scale-horiz-incr
            neck-scale-vert-incr neck-trans-forward neck-trans-up
            pelvis-tone-incr stomach-tone-incr torso-muscle-dorsi-incr torso-muscle-pectoral-incr
            torso-scale-depth-incr torso-scale-horiz-incr torso-scale-vert-incr torso-trans-forward torso-trans-up
            """,
        ),
        (
            ("l-", "r-"),
            """
            foot-scale-depth-incr foot-scale-horiz-incr foot-scale-incr foot-scale-vert-incr
            hand-fingers-diameter-incr hand-fingers-distance-incr hand-fingers-length-incr hand-scale-incr
            leg-valgus-incr lowerarm-fat-incr lowerarm-muscle-incr lowerarm-scale-depth-incr lowerarm-scale-horiz-incr
            lowerarm-scale-vert-incr lowerleg-fat-incr lowerleg-muscle-incr lowerleg-scale-depth-incr
            lowerleg-scale-horiz-incr lowerleg-scale-vert-incr upperarm-fat-incr upperarm-muscle-incr
            upperarm-scale-depth-incr upperarm-scale-horiz-incr upperarm-scale-vert-incr
            upperarm-shoulder-muscle-incr upperleg-fat-incr upperleg-muscle-incr upperleg-scale-depth-incr
            upperleg-scale-horiz-incr upperleg-scale-vert-incr
            """,
        ),
    )
    for name in names.split()
}
