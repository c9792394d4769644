import ast
import pathlib

import compass_localization as compass


def public(thing):
    return {name for name in dir(thing) if not name.startswith("_")}


def test_stubs_say_what_there_is():
    stub = ast.parse((pathlib.Path(compass.__file__).parent / "__init__.pyi").read_text())
    functions = {node.name for node in stub.body if isinstance(node, ast.FunctionDef)}
    classes = {node.name: node for node in stub.body if isinstance(node, ast.ClassDef)}
    assert functions | set(classes) | {"__version__"} == set(compass.__all__)
    for name, node in classes.items():
        if name == "CompassError":
            continue
        told = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
        assert {item for item in told if not item.startswith("_")} == public(getattr(compass, name)), name


def test_everything_is_documented():
    for name in compass.__all__:
        thing = getattr(compass, name)
        if name != "__version__":
            assert thing.__doc__, name
        if isinstance(thing, type) and name != "CompassError":
            for member in public(thing):
                assert getattr(thing, member).__doc__, f"{name}.{member}"
