"""What to say of strands whose going on is a guess."""

from collections.abc import Sequence

from imaging.trace import Strand


def doubt_notes(strands: Sequence[Strand]) -> list[str]:
    """Say where strands may go on otherwise than they were followed."""
    places = [
        f"{number} at " + ", ".join(f"({x:.0f}, {y:.0f})" for x, y in strand.doubts)
        for number, strand in enumerate(strands, start=1)
        if len(strand.doubts)
    ]
    if not places:
        return []
    return [
        "strands whose going on is a guess, as another of their colour could or their colour "
        f"changes unseen (x, y): {'; '.join(places)}"
    ]
