"""The schemes of a fluid: how pressure gradients and the source of the PPE are formed."""

CONSERVATIVE, CORRECTED, KOSHIZUKA_OKA = 0, 1, 2
# by their names in a scene
SCHEMES = {"conservative": CONSERVATIVE, "corrected": CORRECTED, "koshizuka_oka": KOSHIZUKA_OKA}
