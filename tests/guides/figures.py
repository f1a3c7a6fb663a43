"""Figures of guides that `tests/guides/run` compares with what their commands print."""

# Files beside the commands of a guide: their names there, and below ../shared.
FILES = {
    "assets/guides/from-ct-to-dem.md": {
        "ct.nii.gz": "volumes/spine_tptbox_ct.nii.gz",
        "labels.nii.gz": "volumes/spine_tptbox_subreg.nii.gz",
        "vert.nii.gz": "volumes/spine_tptbox_vert.nii.gz",
    },
}

# Words of the command, how the guide states the figure, and how the command prints it.
FIGURES = {
    "assets/guides/from-ct-to-dem.md": [
        ("pack --parts body.toml", r"packs ([\d,]+) spheres", r"spheres +([\d,]+)"),
        ("pack --parts body.toml", r"([\d,]+) of them join two parts", r"([\d,]+) contacts between parts"),
        ("-o trabecular.vdb", r"BV/TV becomes ([\d.]+)", r"BV/TV ([\d.]+), [\d.]+ centers"),
        ("-o trabecular.vdb", r"here ([\d.]+) % of the solid is in the largest", r"([\d.]+) % of the solid is in"),
    ],
}
