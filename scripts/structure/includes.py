"""Include direction: the layers of docs/architecture.md, and no cycles."""

import re

# Folder of src/tvl -> height. Equal heights may include each other unless listed as siblings.
LAYERS = {
    "base": 0,
    "geometry": 1, "optim": 1,
    "sensor": 2, "frame": 2, "map": 2,
    "factors": 3, "registration": 3,
    "vision": 4, "lidar": 4, "depth": 4, "odometry": 4, "mapping": 4, "loop": 4, "pose_graph": 4,
    "slam": 5,
    "io": 6, "eval": 6, "sim": 6, "report": 6,
    "cli": 7,
}
SIBLINGS = {4}  # the paper's boxes never include each other
LEAVES = {6: {"sim": {"io", "eval"}, "report": {"io", "eval"}}}  # who may use whom among the leaves
_INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


def folder(path):
    """tvl folder of src/tvl/FOLDER/..., else None."""
    parts = path.split("/")
    return parts[2] if path.startswith("src/tvl/") and len(parts) > 3 else None


def includes_of(text):
    return _INCLUDE.findall(text)


def allowed(source, target):
    """Whether folder `source` may include folder `target`."""
    if source == target:
        return True
    height, below = LAYERS[source], LAYERS[target]
    if height != below:
        return below < height
    if height in LEAVES:
        return target in LEAVES[height].get(source, ())
    return height not in SIBLINGS


def direction_errors(texts, is_test):
    """texts: path -> content. One message for each include that points up or sideways."""
    errors = []
    for path, text in texts.items():
        source = folder(path)
        if source is None:
            continue
        if source not in LAYERS:
            errors.append(f"{path}: folder '{source}' has no layer (scripts/structure/includes.py)")
            continue
        for name in includes_of(text):
            target = folder("src/" + name)
            if target is None:
                continue
            if is_test("src/" + name) and not is_test(path):
                errors.append(f"{path}: includes the test helper {name}")
            elif target not in LAYERS:
                errors.append(f"{path}: includes the unknown folder '{target}'")
            elif not is_test(path) and not allowed(source, target):
                errors.append(f"{path}: {source} must not include {target} ({name})")
    return errors


def graphs(texts, is_test):
    """(file graph, folder graph) of the sources under src/, tests left out; edges are sorted."""
    files, folders = {}, {}
    for path, text in texts.items():
        if folder(path) is None or is_test(path):
            continue
        targets = ["src/" + name for name in includes_of(text) if "src/" + name in texts]
        files[path] = sorted(set(targets))
        edges = folders.setdefault(folder(path), set())
        edges.update(folder(t) for t in targets if folder(t) not in (None, folder(path)))
    return files, {k: sorted(v) for k, v in folders.items()}


def cycles(graph):
    """The cycles met by a depth-first walk: a list of paths whose ends are equal."""
    state, found = {}, []

    def visit(node, trail):
        state[node] = "open"
        for target in graph.get(node, ()):
            if state.get(target) == "open":
                found.append(trail[trail.index(target):] + [target])
            elif target not in state:
                visit(target, trail + [target])
        state[node] = "done"

    for node in sorted(graph):
        if node not in state:
            visit(node, [node])
    return found
