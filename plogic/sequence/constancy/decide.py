"""Case D decided (§4.4): from unexplained data of moved views to unknown objects, noise, and undecided ones.

A datum has one cause. So which tracks there are is decided of all together: by a packing of greatest weight, and the
probability of each track in it.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from kb.clouds.cloud import Rates
from plogic.sequence.constancy.result import Constancy, PhysicalFeature, UnknownObject
from plogic.sequence.constancy.sight_lines import Sights, View, sights_of
from plogic.sequence.constancy.tracks import DEPTHS, MIN_PARALLAX, Tracks, tracks_of
from plogic.sequence.constancy.weights import Hidden, company_of, log_weights, spacing


def packing(data: Indices, weight: Floats) -> Indices:
    """Indices, ascending, of tracks ``data`` (T, V) that share no datum, of great total ``weight`` (T,).

    Greedy, the heaviest first; then one is put in wherever it weighs more than all that it displaces, the most gainful
    first, until none does. Of equally heavy ones the first. It ends, for the total rises each time.
    """
    owner = _owners(data)
    for t in np.argsort(-weight, kind="stable").tolist():
        if weight[t] <= 0.0:
            break
        if not displaced(data[t : t + 1], owner)[0].any():
            _put(owner, data[t], t)
    while True:
        gain = weight - _cost(data, owner, weight)
        best = int(gain.argmax()) if len(gain) else -1
        if best < 0 or gain[best] <= 1e-9:
            break
        owner[np.isin(owner, displaced(data[best : best + 1], owner)[1])] = -1
        _put(owner, data[best], best)
    return np.unique(owner[owner >= 0])


def probabilities(data: Indices, weight: Floats, chosen: Indices) -> Floats:
    """(C,) that each chosen track is a physical feature, with all others as they are.

    Of the worlds that differ from the packing in what takes this track's data: itself, nothing, or a rival that
    displaces it (and, at their cost, others). Those count for it that keep two of its data together.
    """
    owner = _owners(data)
    for t in chosen.tolist():
        _put(owner, data[t], t)
    cost, own = _cost(data, owner, weight), _owned(data, owner)
    answers = []
    for t in chosen.tolist():
        shared = (own == t).sum(axis=1)
        rivals = np.flatnonzero((shared > 0) & (np.arange(len(data)) != t))
        every = np.concatenate([[weight[t], 0.0], weight[rivals] - (cost[rivals] - weight[t])])
        every = np.exp(every - float(every.max()))
        answers.append((every[0] + every[2:][shared[rivals] > 1].sum()) / every.sum())
    return np.array(answers)


def displaced(data: Indices, owner: Indices) -> tuple[Indices, Indices]:
    """Of tracks (T, V): (T, V) whether a datum is taken; and all those that took one."""
    own = _owned(data, owner)
    return np.asarray(own >= 0), np.unique(own[own >= 0])


def _owners(data: Indices) -> Indices:
    """(V, N) the chosen track of each datum: -1, nobody yet."""
    return np.full((data.shape[1], int(data.max(initial=0)) + 1), -1, np.intp)


def _put(owner: Indices, row: Indices, track: int) -> None:
    views = np.flatnonzero(row >= 0)
    owner[views, row[views]] = track


def _owned(data: Indices, owner: Indices) -> Indices:
    """(T, V) the chosen track that has each datum of each track, -1 where nobody has."""
    return np.where(data >= 0, owner[np.arange(data.shape[1]), data], -1)


def _cost(data: Indices, owner: Indices, weight: Floats) -> Floats:
    """(T,) the weight of all the chosen tracks that each would displace, each counted once."""
    own = np.sort(_owned(data, owner), axis=1)
    first = own >= 0
    first[:, 1:] &= own[:, 1:] != own[:, :-1]
    return np.where(first, weight[own], 0.0).sum(axis=1) if len(data) else np.zeros(0)


REACH = 2.0
"""Two features are of one object where they are nearer than so many spacings (the median distance to a third
neighbour), or linked by others."""


def clusters(at: Floats) -> list[Indices]:
    """Indices of places (N, 3) m, an array a cluster.

    The largest first, of equally large ones that with the first place.
    """
    from scipy.cluster.hierarchy import fcluster, linkage

    if len(at) < 2:
        return [np.arange(len(at))] if len(at) else []
    labels = fcluster(linkage(at, "single"), REACH * spacing(at), "distance")
    groups = [np.flatnonzero(labels == label) for label in np.unique(labels)]
    return sorted(groups, key=lambda group: (-len(group), int(group[0])))


PHYSICAL = 0.5
"""Probability from which a feature is called physical: there is nothing better to call it."""
CERTAIN = 0.95
"""Probability from which it tells where others are."""
HOPELESS = -6.0
"""w below which a track is neither taken nor a rival that counts."""


MOST_ALIKE = 1_000_000
"""Pairs that the data of one type make between two views, above which nothing is sought among them: nothing tells which
belong together. In two photos of 14,000 data one visual word, of sides of edges, makes 60 million, the next 50,000."""


def unknown_objects(
    views: Sequence[View],
    unexplained: Mapping[str, Sequence[str]],
    rates: Rates,
    hidden: Hidden | None = None,
    *,
    looks: int = 2,
) -> Constancy:
    """What is physical of the ``unexplained`` data (ids by view).

    Seen at one place from two views or more, and again where it should be. Data of which there are too many alike are
    undecided.

    ``hidden`` says which places the known bodies hide from a view (``plogic.sequence.views.panorama``). A pure
    function of all the views: the order of data changes nothing but the numbering. Two looks: the second knows where
    the first found features, for features come in objects; with ``looks`` 1 there is none.
    """
    alike = _too_many_alike(views, unexplained)
    told = {view.id: [name for name in unexplained.get(view.id, ()) if name not in alike[view.id]] for view in views}
    found = _decided(views, told, rates, hidden, looks)
    open_ones = {
        name: (*some, *(i for i in unexplained.get(name, ()) if i in alike[name]))
        for name, some in found.undecided.items()
    }
    return replace(found, undecided=open_ones)


def _too_many_alike(views: Sequence[View], unexplained: Mapping[str, Sequence[str]]) -> dict[str, set[str]]:
    """Those of the data, by view, whose type makes more than ``MOST_ALIKE`` pairs between two views."""
    kinds = {view.id: {a.id: a.type for a in view.gamma.appearances} for view in views}
    of = {view.id: [(kinds[view.id][name], name) for name in unexplained.get(view.id, ())] for view in views}
    counts = [Counter(kind for kind, _ in rows) for rows in of.values()]
    many = {kind for one, other in combinations(counts, 2) for kind in one if one[kind] * other[kind] > MOST_ALIKE}
    return {view: {name for kind, name in rows if kind in many} for view, rows in of.items()}


def _decided(
    views: Sequence[View],
    unexplained: Mapping[str, Sequence[str]],
    rates: Rates,
    hidden: Hidden | None,
    looks: int,
) -> Constancy:
    """What is physical, noise, and undecided of data that can be told apart."""
    sights = sights_of(views, unexplained, rates)
    tracks = tracks_of(sights) if len(views) > 1 and sights.types else None
    if tracks is None or not len(tracks.kind):
        return _answer(sights, None, np.zeros(0), hidden)
    weight = log_weights(sights, tracks, hidden)
    tracks, weight = tracks.take(weight > HOPELESS - FAR), weight[weight > HOPELESS - FAR]
    chosen = packing(tracks.data, weight)
    sure = chosen[probabilities(tracks.data, weight, chosen) >= CERTAIN]
    company = company_of(tracks.data[sure], tracks.places.at[sure])
    if company is not None and looks > 1:
        weight = log_weights(sights, tracks, hidden, company)
    chosen = packing(tracks.data, weight)
    probability = probabilities(tracks.data, weight, chosen)
    physical = probability >= PHYSICAL
    return _answer(sights, tracks.take(chosen[physical]), probability[physical], hidden)


FAR = 8.0
"""What company may add to w at most, about."""


def _answer(sights: Sights, tracks: Tracks | None, probability: Floats, hidden: Hidden | None) -> Constancy:
    data = np.zeros((0, len(sights.views)), np.intp) if tracks is None else tracks.data
    noise, undecided = {}, {}
    for v, view in enumerate(sights.views):
        taken = set(data[data[:, v] >= 0, v].tolist())
        told = tellable(sights, v, hidden).tolist()
        noise[view.id] = tuple(name for i, name in enumerate(sights.ids[v]) if i not in taken and told[i])
        undecided[view.id] = tuple(name for i, name in enumerate(sights.ids[v]) if i not in taken and not told[i])
    unknown = (
        ()
        if tracks is None
        else tuple(
            _object(f"u{n}", sights, tracks.take(group), probability[group])
            for n, group in enumerate(clusters(tracks.places.at), 1)
        )
    )
    return Constancy(unknown, noise, undecided)


def _object(name: str, sights: Sights, tracks: Tracks, probability: Floats) -> UnknownObject:
    worst = np.sqrt(np.linalg.eigvalsh(tracks.places.covariance)[:, -1])
    rows = zip(tracks.data.tolist(), tracks.kind, tracks.places.at, worst.tolist(), probability.tolist(), strict=True)
    features = [
        PhysicalFeature(
            f"{name}/f{i}",
            sights.types[kind],
            at,
            sigma,
            chance,
            {sights.views[v].id: sights.ids[v][d] for v, d in enumerate(row) if d >= 0},
        )
        for i, (row, kind, at, sigma, chance) in enumerate(rows, 1)
    ]
    return UnknownObject(name, float(1.0 - np.prod(1.0 - probability)), tuple(features))


STEPS = 24
"""Depths, evenly spaced in their logarithm, at which a datum's unknown place is tried."""
SHARE = 0.25
"""Share of these at which another view must have been able to tell. Noise is the more probable from the first of them
on; this leaves a margin."""


def tellable(sights: Sights, v: int, hidden: Hidden | None) -> Mask:
    """(N,) of the data of view ``v``: whether another view could have told.

    At a quarter of the depths or more where its place may be, some other view has it in its image, hidden by nothing
    known, along a line of sight that makes ``MIN_PARALLAX`` or more with its own.
    """
    count = len(sights.ids[v])
    depths = np.geomspace(*DEPTHS, STEPS)
    points = (np.column_stack([sights.xy[v, :count], np.ones(count)])[:, None] * depths[:, None]).reshape(-1, 3)
    frame = np.linalg.inv(sights.camera_from_world[v])
    world = points @ frame[:3, :3].T + frame[:3, 3]
    told = sights.in_image(world)
    if hidden is not None:
        told &= ~np.stack([hidden(view.id, world) for view in sights.views], axis=-1)
    sight = world[:, None] - sights.eye
    sight /= np.maximum(np.linalg.norm(sight, axis=-1, keepdims=True), 1e-12)
    aside = np.einsum("pvi,pi->pv", sight, sight[:, v]) <= np.cos(MIN_PARALLAX)
    return np.asarray((told & aside).any(axis=1).reshape(count, STEPS).mean(axis=1) >= SHARE)
