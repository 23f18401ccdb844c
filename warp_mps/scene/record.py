"""What the records of a case share: their own fields are checked as soon as one is made."""

from __future__ import annotations


class Record:
    """Base of the dataclasses that a scene consists of.

    Raises:
        InputError: A field holds something of another type, a number out of its range, or a name that is not allowed.
            What depends on other records is checked when they are put together as a `Scene`.
    """

    def __post_init__(self) -> None:
        from warp_mps.scene.validation.record import check_record

        check_record(self)
