"""The candidate list of contact: for every particle the others that it could touch, sorted by group of bodies.

Candidates are found with `wp.HashGrid`, up to a margin beyond the support of the contact law. The list is rebuilt,
inside the replayed step, when a particle has moved by half of that margin. Particles far from the bounding boxes of all
other bodies are not searched.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD
from warp_mps.elastic.contact.kernels import contact_funcs

# largest number of groups of bodies near one particle
FACES = 8
# particles of one bounding box
CHUNK = 256


@functools.cache
def search_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `locate`, `chunk_boxes`, `body_boxes` and `candidates`."""
    real, vec, vec3 = types.real, types.vec, types.vec3
    pair_support = contact_funcs(types).pair_support

    @types.func(METHOD)
    def precedes(j: wp.int32, k: wp.int32, group: wp.array(dtype=wp.int32)) -> wp.bool:
        """Order of the list: by group, then by particle."""
        return group[j] < group[k] or (group[j] == group[k] and j < k)

    @types.kernel(METHOD)
    def locate(
        # Model:
        reference: wp.array(dtype=vec),  # reference positions X_i [m], [n]
        margin: real,  # margin of the list beyond the support [m]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        u_listed: wp.array(dtype=vec),  # displacements that the list was made at [m], [n]
        # State out:
        points_out: wp.array(dtype=vec3),  # positions [m], [n]
        stale_out: wp.array(dtype=wp.int32),  # 1 if the list must be renewed, else 0, [1]
    ):
        """Positions x = X + u for the grid, and whether any |u - u_listed| exceeds half of the margin."""
        i = wp.tid()
        x = reference[i] + u[i]
        point = vec3()
        for axis in range(wp.static(types.dimension)):
            point[axis] = x[axis]
        points_out[i] = point
        moved = u[i] - u_listed[i]
        if wp.dot(moved, moved) > real(0.25) * margin * margin:
            stale_out[0] = 1

    @types.kernel(METHOD)
    def chunk_boxes(
        # Model:
        chunks: wp.array(dtype=wp.vec2i),  # first particle of each chunk and one past its last, [chunks]
        # State in:
        points: wp.array(dtype=vec3),  # positions [m], [n]
        # State out:
        low_out: wp.array(dtype=vec3),  # lowest corners [m], [boxes]
        high_out: wp.array(dtype=vec3),  # highest corners [m], [boxes]
    ):
        """Bounding box of the particles of a chunk of a body: min_i x_i and max_i x_i."""
        c = wp.tid()
        low = points[chunks[c][0]]
        high = low
        for i in range(chunks[c][0] + 1, chunks[c][1]):
            low = wp.min(low, points[i])
            high = wp.max(high, points[i])
        low_out[c] = low
        high_out[c] = high

    @types.kernel(METHOD)
    def body_boxes(
        # Model:
        first: wp.array(dtype=wp.int32),  # first chunk of each body, [bodies + 1]
        # State in:
        low: wp.array(dtype=vec3),  # lowest corners [m], [boxes]
        high: wp.array(dtype=vec3),  # highest corners [m], [boxes]
        # State out:
        low_out: wp.array(dtype=vec3),  # lowest corners [m], [boxes]
        high_out: wp.array(dtype=vec3),  # highest corners [m], [boxes]
    ):
        """Bounding box of a body: the union of those of its chunks."""
        b = wp.tid()
        lowest = low[first[b]]
        highest = high[first[b]]
        for c in range(first[b] + 1, first[b + 1]):
            lowest = wp.min(lowest, low[c])
            highest = wp.max(highest, high[c])
        low_out[b] = lowest
        high_out[b] = highest

    @types.func(METHOD)
    def in_reach(
        x: vec3,
        own: wp.int32,
        reach: real,
        low: wp.array(dtype=vec3),
        high: wp.array(dtype=vec3),
        group: wp.array(dtype=wp.int32),
    ) -> wp.bool:
        """Whether the box of a body of another group is within reach; true where there are no boxes."""
        near = low.shape[0] == 0
        for b in range(low.shape[0]):
            if group[b] != own and not near:
                outside = wp.max(wp.max(low[b] - x, x - high[b]), vec3())
                near = wp.max(outside) <= reach
        return near

    @types.func(METHOD)
    def may_touch(
        i: wp.int32,
        j: wp.int32,
        reference: wp.array(dtype=vec),
        group: wp.array(dtype=wp.int32),
        apart: wp.array(dtype=real),
        within_group: wp.int32,
    ) -> wp.bool:
        """Whether two particles can be in contact: wall-wall pairs are excluded."""
        if group[i] != group[j]:
            return not wp.isinf(wp.min(apart[i], apart[j]))
        # reference neighbours are held apart by elasticity
        close = wp.length(reference[j] - reference[i]) < wp.max(apart[i], apart[j])
        return within_group == 1 and not close

    @types.kernel(METHOD)
    def candidates(
        # Model:
        grid: wp.uint64,  # hash grid of the particles
        reach: real,  # largest distance of a candidate [m]
        margin: real,  # margin of the list beyond the support [m]
        low: wp.array(dtype=vec3),  # lowest corners [m], [boxes]
        high: wp.array(dtype=vec3),  # highest corners [m], [boxes]
        box_group: wp.array(dtype=wp.int32),  # group of each body, [bodies]
        spacing: wp.array(dtype=real),  # particle spacings [m], [n]
        reference: wp.array(dtype=vec),  # reference positions X_i [m], [n]
        group: wp.array(dtype=wp.int32),  # group of bodies of each particle, [n]
        apart: wp.array(dtype=real),  # least reference distance in a group, infinite for walls [m], [n]
        within_group: wp.int32,  # 1 for self-contact, else 0
        start: wp.array(dtype=wp.int32),  # first place of each row of candidates, [n + 1]
        # State in:
        points: wp.array(dtype=vec3),  # positions [m], [n]
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        # State out:
        listed_out: wp.array(dtype=wp.int32),  # candidates, sorted by group, [entries]
        faces_out: wp.array(dtype=wp.int32),  # number of groups near each particle, [n]
        facing_out: wp.array(dtype=wp.int32, ndim=2),  # these groups, [n, faces]
        end_out: wp.array(dtype=wp.int32, ndim=2),  # one past the last candidate of each, [n, faces]
        u_listed_out: wp.array(dtype=vec),  # displacements that the list is made at [m], [n]
        stale_out: wp.array(dtype=wp.int32),  # 1 if the list must be renewed, else 0, [1]
        overflow_out: wp.array(dtype=wp.int32),  # number + 1 of a particle without room, [1]
    ):
        """Candidates j with |x_ij| < margin + support, sorted, so that sums do not depend on the age of the list.

        `start[i]` is where a particle's row begins; of its `faces[i]` groups, `facing[i, s]` is the group and
        `end[i, s]` one past its last entry.
        """
        i = wp.tid()
        first = start[i]
        last = first
        if in_reach(points[i], group[i], reach, low, high, box_group):
            for j in wp.hash_grid_query(grid, points[i], reach):
                near = j != i and wp.length(points[j] - points[i]) < margin + pair_support(spacing[i], spacing[j])
                if near and may_touch(i, j, reference, group, apart, within_group):
                    if last < start[i + 1]:
                        k = last
                        while k > first and precedes(j, listed_out[wp.max(k - 1, first)], group):
                            listed_out[k] = listed_out[k - 1]
                            k -= 1
                        listed_out[k] = j
                        last += 1
                    else:
                        overflow_out[0] = i + 1
        faces = wp.int32(0)
        for k in range(first, last):
            other = group[listed_out[k]]
            if faces == 0 or facing_out[i, wp.max(faces - 1, 0)] != other:
                if faces < facing_out.shape[1]:
                    facing_out[i, faces] = other
                    faces += 1
                else:
                    overflow_out[0] = i + 1
            end_out[i, faces - 1] = k + 1
        faces_out[i] = faces
        u_listed_out[i] = u[i]
        if i == 0:
            stale_out[0] = 0

    return SimpleNamespace(locate=locate, chunk_boxes=chunk_boxes, body_boxes=body_boxes, candidates=candidates)
