"""Functions for shaders: their declarations in WGSL, and calls of them in other languages."""

import re

NAMES = {
    "wgsl": {name: name for name in ["f32", "vec2f", "vec3f", "vec4f", "mat4x4f"]},
    "glsl": {"f32": "float", "vec2f": "vec2", "vec3f": "vec3", "vec4f": "vec4", "mat4x4f": "mat4"},
    "hlsl": {"f32": "float", "vec2f": "float2", "vec3f": "float3", "vec4f": "float4", "mat4x4f": "float4x4"},
    "msl": {t: f"metal::float{n}" for t, n in [("vec2f", 2), ("vec3f", 3), ("vec4f", 4)]}
    | {"f32": "float", "mat4x4f": "metal::float4x4"},
}
SIZES = {"f32": 1, "vec2f": 2, "vec3f": 3, "vec4f": 4, "mat4x4f": 16}
IN_MSL = {"f32": "floats", "vec3f": "colors", "vec4f": "vectors"}


def parts(ty):
    """The element of a type and how many there are; None for what is no array."""
    found = re.fullmatch(r"array<(\w+), (\d+)>", ty)
    return (found[1], int(found[2])) if found else (ty, None)


def numbers(ty):
    element, count = parts(ty)
    return SIZES[element] * (count or 1)


class Function:
    """A function: its name, the types of its arguments and of its result."""

    def __init__(self, wgsl, name):
        found = re.search(rf"fn {name}\((.*?)\) -> (.*?) \{{", wgsl)
        self.name, self.result = name, found[2]
        self.arguments = re.findall(r": (array<\w+, \d+>|\w+)", found[1])
        self.given = sum(map(numbers, self.arguments))
        self.found = numbers(self.result)

    def call(self, language, number, put):
        """Statements that read arguments by `number(k)`, call, and hand number k of the result to `put(k, value)`."""
        lines, first = [], 0
        for place, ty in enumerate(self.arguments):
            lines.append(f"{declared(language, ty, f'a_{place}')} = {made(language, ty, first, number)};")
            first += numbers(ty)
        values = ", ".join(f"a_{place}" for place in range(len(self.arguments)))
        lines.append(f"{declared(language, self.result, 'found')} = {self.name}({values});")
        element, count = parts(self.result)
        size, inner = SIZES[element], ".inner" if language == "msl" else ""
        for k in range(self.found):
            item = "found" if count is None else f"found{inner}[{k // size}]"
            lines.append(put(k, item if size == 1 else f"{item}.{'xyzw'[k % size]}"))
        return "\n  ".join(lines)


def declared(language, ty, name):
    element, count = parts(ty)
    if language == "wgsl":
        return f"let {name}"
    if count is None:
        return f"{NAMES[language][element]} {name}"
    if language == "msl":
        return f"array_of_{count}_{IN_MSL[element]} {name}"
    return f"{NAMES[language][element]} {name}[{count}]"


def made(language, ty, first, number):
    """A value of a type, from number `first` on."""
    element, count = parts(ty)
    size, name = SIZES[element], NAMES[language][element]

    def one(k):
        at = first + size * k
        if size == 1:
            return number(at)
        if language == "msl" and size == 16:
            columns = ["metal::float4{" + ", ".join(number(at + 4 * c + r) for r in range(4)) + "}" for c in range(4)]
            return f"{name}({', '.join(columns)})"
        list_of = ", ".join(number(at + c) for c in range(size))
        return f"{name}{{{list_of}}}" if language == "msl" else f"{name}({list_of})"

    if count is None:
        return one(0)
    items = ", ".join(map(one, range(count)))
    forms = {"wgsl": f"{ty}({items})", "glsl": f"{name}[{count}]({items})", "hlsl": f"{{{items}}}", "msl": f"{{{{{items}}}}}"}
    return forms[language]
