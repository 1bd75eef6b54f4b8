"""The JSON that the command line and the service both give, as INTERFACES.md promises it."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class Schema(BaseModel):
    """Base of all: unknown fields are refused, so that a misspelt one is not lost."""

    model_config = ConfigDict(extra="forbid")


class RejectedAnswer(Schema):
    """An alternative that was not chosen, and what spoke against it."""

    type: str
    rule: str
    because: str


class OverrideAnswer(Schema):
    """What a user decided, and why."""

    type: str
    author: str
    reason: str


class DecisionAnswer(Schema):
    """Why a node is what it is. `rule` and the rest are what the rules say, also where an override stands."""

    rule: str
    certainty: float
    because: str
    rejected: list[RejectedAnswer]
    by_rule: str = Field(description="type that the rules would give")
    margin: float | None = Field(default=None, description="distance to the nearest threshold, as a share of it")
    review: bool = Field(default=False, description="that margin is so small that an analyst should look")
    conflicts: list[str] = Field(default_factory=list)
    override: OverrideAnswer | None = Field(default=None, description="the user's decision, beside the rules")


class SectionAnswer(Schema):
    """A beam's section about its centroid, y and z along the section's own axes."""

    shape: str
    area: float
    iyy: float
    izz: float
    iyz: float
    j: float
    shear_area_y: float
    shear_area_z: float


class SegmentAnswer(Schema):
    """A part that is meshed one way. `holes`: inner boundary loops; `radius`: of the mid-surface."""

    id: str
    node: str
    name: str | None
    type: str
    origin: str
    volume: float
    thickness: float | None
    length: float | None
    radius: float | None
    holes: int | None
    section: SectionAnswer | None
    decision: DecisionAnswer


class JointAnswer(Schema):
    """Where two segments meet."""

    id: str
    kind: str
    segments: list[str]
    area: float
    gap: float = Field(default=0.0, description="distance of the faces, where a stated gap counts as touching")


class ChecksAnswer(Schema):
    """mass_error: of the segments (`classify`) or of the meshed model (`mesh`) against the solid, as a share."""

    model_config = ConfigDict(extra="allow")

    volume_of_segments: float
    mass_error: float


class Classification(Schema):
    """`csgmesh classify --json` and GET /v1/models/{id}/segments."""

    model: str
    units: str
    volume: float
    rule_base: str
    segments: list[SegmentAnswer]
    joints: list[JointAnswer]
    checks: ChecksAnswer


class MassAnswer(Schema):
    """Mass of the solid and of the finite element model, in the unit set; error as a share of the solid's."""

    solid: float
    model: float
    error: float


class SegmentSizeAnswer(Schema):
    """The size of a segment that has another one than the model."""

    segment: str
    size: float
    because: str


class SizeAnswer(Schema):
    """Target length of an element's edge, in model units, and what it comes from."""

    value: float
    automatic: bool
    because: str
    segments: list[SegmentSizeAnswer] = Field(description="those whose size differs, and why")


class MeshAnswer(Classification):
    """`csgmesh mesh --json` and GET /v1/meshes/{id}. bricks: how each was meshed and why, by segment id."""

    size: SizeAnswer
    nodes: int
    elements: dict[str, int]
    bricks: dict[str, str]
    couplings: dict[str, int]
    components: int
    quality: dict[str, Any]
    mass: MassAnswer
    ledger: list[dict[str, Any]]
    warnings: list[str]
    seconds: dict[str, float]


class SolidAnswer(Schema):
    """`csgmesh evaluate --json`."""

    model: str
    units: str
    volume: float
    area: float
    bounds: list[list[float]]
    triangles: int


class ErrorPlace(Schema):
    """Where the input is wrong; line and column from 1."""

    file: str
    line: int
    column: int


class Problem(Schema):
    """RFC 9457 problem details; `detail` is the message that the command line gives."""

    type: str
    title: str
    status: int
    detail: str
    place: ErrorPlace | None = None
