#!/usr/bin/env python3
"""Draws the drawings of docs/theory.md and of the report page, docs/images/*.svg, for light and dark pages, phone and desk.

    tools/drawings.py            writes the drawings that are out of date
    tools/drawings.py --check    writes nothing; status 1 when one is out of date

A text may hold *italics*, **bold**, _{subscripts} and ^{superscripts}. A text that is wider than its box
breaks the program off.
"""
import math
import pathlib
import re
import sys
import unicodedata
from xml.sax.saxutils import escape

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDER = ROOT / "docs" / "images"
PAGES = ROOT / "python" / "gracecg" / "pages" / "drawings"        # of the report page

WIDTH = 540
BODY, SMALL = 17, 15            # Sizes of letters: at 390 pixels still 12 and 11 pixels
LEADING = 1.32                  # Of a line, in sizes of its letters
PADDING = 10                    # Between a box and its text

# As in the style sheet of the program's pages. Presentation by class and without variables, which some
# programs that draw SVG do not know.
COLOURS = {"paper": ("#ffffff", "#14181d"), "ink": ("#1b1f24", "#e6e9ed"), "soft": ("#545b64", "#a9b1bb"),
           "rule": ("#b9c0c8", "#4a535e"), "box": ("#f3f5f7", "#1d232a"), "blue": ("#0550ae", "#7cb7ff"),
           "green": ("#0f6b35", "#6fd08c"), "red": ("#a8201a", "#ff9a92")}
STYLE = ("text{font-family:\"Liberation Sans\",Arial,Helvetica,sans-serif}"
         "path{fill:none;stroke-linejoin:round;stroke-linecap:round}"
         ".thin{stroke-width:1.2}.line{stroke-width:1.7}.bold{stroke-width:2.6}"
         ".dashed{stroke-dasharray:5 4}.frame{stroke-width:1.4}")


def style():
    """Colours by class: fill of text and areas (.ink), of lines (.s-ink); dark where the reader likes it."""
    sheets = ["".join(f".{name}{{fill:{pair[dark]}}}.s-{name}{{stroke:{pair[dark]}}}"
                      for name, pair in COLOURS.items()) for dark in (0, 1)]
    return f"{STYLE}{sheets[0]}@media (prefers-color-scheme:dark){{{sheets[1]}}}"


def number(value):
    text = f"{value:.1f}".removesuffix(".0")
    return "0" if text == "-0" else text


def text_width(text, size):
    """About that in Helvetica, of the text without its marks."""
    width = 0.0
    for char in re.sub(r"\*+|[_^]\{|\}", "", text):
        if not unicodedata.combining(char):
            width += (0.28 if char in " .,:;'’|ijlftI!/()[]-″′" else 0.85 if char in "mMW%…"
                      else 0.70 if char.isupper() else 0.58)
    return width*size


def marked(text, size):
    """A text with its marks as tspan elements."""
    out, shift, bold, italic = [], 0.0, False, False
    for part in re.findall(r"\*\*|\*|[_^]\{.*?\}|[^*_^]+", text):
        if part == "**":
            bold = not bold
        elif part == "*":
            italic = not italic
        else:
            attributes, wanted = "", 0.0
            if part[0] in "_^":
                wanted = 0.25*size if part[0] == "_" else -0.38*size
                attributes, part = f' font-size="{number(0.72*size)}"', part[2:-1]
            if wanted != shift:
                attributes += f' dy="{number(wanted - shift)}"'
                shift = wanted
            attributes += ' font-weight="bold"'*bold + ' font-style="italic"'*italic
            out.append(f"<tspan{attributes}>{escape(part)}</tspan>" if attributes else escape(part))
    return "".join(out)


def box_height(text):
    """Of a box about a text."""
    return sum(LEADING*(SMALL if line[0] == "~" else BODY) for line in text.split("\n")) + 1.5*PADDING


class Drawing:
    """An SVG of WIDTH and a height; x to the right, y downwards."""

    def __init__(self, name, title, description, height=0):
        self.name, self.title, self.description, self.height = name, title, description, height
        self.parts = []

    def path(self, points, classes="line s-ink", closed=False):
        steps = " ".join(f"{number(x)},{number(y)}" for x, y in points)
        self.parts.append(f'<path class="{classes}" d="M{steps}{"z" if closed else ""}"/>')

    def circle(self, x, y, radius, classes):
        self.parts.append(f'<path class="{classes}" d="M{number(x - radius)},{number(y)}'
                          f'a{number(radius)},{number(radius)} 0 1 0 {number(2*radius)},0'
                          f'a{number(radius)},{number(radius)} 0 1 0 {number(-2*radius)},0z"/>')

    def arrow(self, points, colour="ink", width="line", dashed=False):
        """A broken line with a head at its last point."""
        (x0, y0), (x1, y1) = points[-2:]
        length = math.hypot(x1 - x0, y1 - y0)
        ux, uy = (x1 - x0)/length, (y1 - y0)/length
        head = 10 if width == "line" else 12
        base = (x1 - head*ux, y1 - head*uy)
        self.path(points[:-1] + [base], f"{width} s-{colour}" + (" dashed" if dashed else ""))
        half = 0.42*head
        self.path([(x1, y1), (base[0] - half*uy, base[1] + half*ux), (base[0] + half*uy, base[1] - half*ux)],
                  colour, closed=True)

    def text(self, x, y, text, size=BODY, anchor="middle", colour="ink", turned=False):
        turn = f' transform="rotate(-90 {number(x)} {number(y)})"' if turned else ""
        self.parts.append(f'<text class="{colour}" x="{number(x)}" y="{number(y)}" font-size="{size}"'
                          f' text-anchor="{anchor}"{turn}>{marked(text, size)}</text>')

    def box(self, x, y, width, text, kind="step", colour="ink"):
        """A box about the lines of a text, with its top at y and its middle at x; gives its bottom.

        Kinds: step (a rectangle), end (round), choice (pointed), data (slanted). A line after `~` is small.
        """
        lines = [(line.removeprefix("~"), SMALL if line[0] == "~" else BODY) for line in text.split("\n")]
        inset = {"step": 0, "end": 8, "choice": 18, "data": 6}[kind]
        for line, size in lines:
            if text_width(line, size) > width - 2*inset - PADDING:
                raise SystemExit(f"{self.name}: a box is too narrow for '{line}'")
        height = box_height(text)
        left, right, bottom = x - width/2, x + width/2, y + height
        classes = f"frame box s-{colour}"
        if kind == "choice":
            self.path([(left, y + height/2), (left + inset, y), (right - inset, y), (right, y + height/2),
                       (right - inset, bottom), (left + inset, bottom)], classes, closed=True)
        elif kind == "data":
            slant = [(left + inset, y), (right, y), (right - inset, bottom), (left, bottom)]
            self.path(slant, classes, closed=True)
        else:
            radius = min(height/2, 22) if kind == "end" else 5
            self.parts.append(f'<rect class="{classes}" x="{number(left)}" y="{number(y)}"'
                              f' width="{number(width)}" height="{number(height)}" rx="{number(radius)}"/>')
        line_top = y + 0.75*PADDING
        for line, size in lines:
            self.text(x, line_top + 0.98*size, line, size)
            line_top += LEADING*size
        return bottom

    def svg(self):
        body = "\n".join(self.parts)
        return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{self.height}"'
                f' viewBox="0 0 {WIDTH} {self.height}" role="img" aria-labelledby="title description">\n'
                f'<!-- Generated by tools/drawings.py -->\n'
                f'<title id="title">{escape(self.title)}</title>\n'
                f'<desc id="description">{escape(self.description)}</desc>\n<style>{style()}</style>\n'
                f'<rect class="paper" width="{WIDTH}" height="{self.height}"/>\n{body}\n</svg>\n')


class View:
    """Orthographic view of a right-handed space with its third axis upwards."""

    def __init__(self, centre, scale, azimuth, elevation):
        a, e = math.radians(azimuth), math.radians(elevation)
        self.centre, self.scale = centre, scale
        self.right = (-math.sin(a), math.cos(a), 0.0)
        self.up = (-math.sin(e)*math.cos(a), -math.sin(e)*math.sin(a), math.cos(e))
        self.towards = (math.cos(e)*math.cos(a), math.cos(e)*math.sin(a), math.sin(e))

    def __call__(self, p):
        return (self.centre[0] + self.scale*dot(self.right, p), self.centre[1] - self.scale*dot(self.up, p))

    def behind(self, p, radius=1.0):
        """Whether a ball about the origin hides the point."""
        depth = dot(self.towards, p)
        return depth < 0 and dot(p, p) - depth**2 < radius**2


def dot(a, b):
    return sum(u*v for u, v in zip(a, b))


def times(factor, a):
    return tuple(factor*u for u in a)


def plus(a, b):
    return tuple(u + v for u, v in zip(a, b))


def unit(a):
    return times(1/math.sqrt(dot(a, a)), a)


def turn(angle, a, b):
    """cos(angle) a + sin(angle) b; deg."""
    return plus(times(math.cos(math.radians(angle)), a), times(math.sin(math.radians(angle)), b))


def round_curve(drawing, view, points, classes, hidden_by=0.0):
    """A curve in space; what the ball hides is dashed and thin."""
    run, was = [], None
    for p in points:
        now = hidden_by > 0 and view.behind(p, hidden_by)
        if was is not None and now != was:
            drawing.path(run + [view(p)], classes if not was else "thin dashed s-rule")
            run = []
        run.append(view(p))
        was = now
    drawing.path(run, classes if not was else "thin dashed s-rule")


def arc_between(a, b, radius):
    """Points of the great arc from one direction to another."""
    a, b = unit(a), unit(b)
    angle = math.degrees(math.acos(dot(a, b)))
    across = unit(plus(b, times(-dot(a, b), a)))
    return [times(radius, turn(angle*i/40, a, across)) for i in range(41)]


def frames():
    drawing = Drawing(
        "frames", "Frames: inertial, Earth-fixed, body axes, orbit-local axes",
        "Above: the Earth with the inertial axes X, Y, Z (mean equator and equinox of J2000), the Earth-fixed "
        "axes x', y', z' turned about Z by the sidereal angle alpha_G, and the orbit with the back and the front "
        "satellite. Below: both satellites seen along the orbit normal, flying to the right. Each has z down and x "
        "towards the other; the line of sight lies about 1 degree below the local horizontal, which is the pitch. "
        "R, T and N are radial, along track and along the orbit normal.", 838)
    draw_earth(drawing)
    drawing.path([(0, 420), (WIDTH, 420)], "thin s-rule")
    draw_satellites(drawing)
    return drawing


def draw_earth(drawing):
    """Inertial and Earth-fixed axes, and the orbit, in the plane of X and Z."""
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    drawing.text(16, 28, "**Inertial and Earth-fixed frame**", anchor="start")
    view = View((212, 232), 104, 55, 26)
    sidereal = 35
    drawing.circle(*view((0, 0, 0)), view.scale, "thin box s-soft")
    round_curve(drawing, view, [turn(a, x, y) for a in range(0, 361, 3)], "thin s-rule", hidden_by=0.999)
    greenwich, east = turn(sidereal, x, y), turn(sidereal + 90, x, y)
    meridian = [turn(a, greenwich, z) for a in range(-90, 91, 3)]
    round_curve(drawing, view, meridian, "thin s-green", hidden_by=0.999)
    orbit = [times(1.5, turn(a, x, z)) for a in range(0, 361, 2)]
    round_curve(drawing, view, orbit, "thin s-soft", hidden_by=1.0)
    drawing.arrow([view((0, 0, 0)), view(times(1.78, x))])
    drawing.arrow([view((0, 0, 0)), view(times(1.86, y))])
    drawing.arrow([view((0, 0, 0)), view(times(1.95, z))])
    drawing.arrow([view((0, 0, 0)), view(times(2.05, greenwich))], "green")
    drawing.arrow([view((0, 0, 0)), view(times(1.75, east))], "green")
    arc = [times(0.72, turn(a, x, y)) for a in range(0, sidereal + 1)]
    drawing.arrow([view(p) for p in arc], "green")
    middle = view(times(0.92, turn(0.42*sidereal, x, y)))
    drawing.text(middle[0] - 2, middle[1] + 8, "*α*_{G}", colour="green")
    tips = {"X": view(times(1.78, x)), "Y": view(times(1.86, y)), "Z": view(times(1.95, z)),
            "x": view(times(2.05, greenwich)), "y": view(times(1.75, east))}
    drawing.text(tips["X"][0] - 12, tips["X"][1] + 6, "*X*")
    drawing.text(tips["Y"][0] + 12, tips["Y"][1] + 12, "*Y*")
    drawing.text(tips["Z"][0] + 10, tips["Z"][1] + 8, "*Z*, *z*′", anchor="start")
    drawing.text(tips["x"][0] - 8, tips["x"][1] + 19, "*x*′", colour="green")
    drawing.text(tips["y"][0] + 8, tips["y"][1] + 5, "*y*′", anchor="start", colour="green")
    for angle, label, name, side in ((15, "*r*_{2}", "back", 0), (48, "*r*_{1}", "front", -4)):
        place = times(1.5, turn(angle, x, z))
        px, py = view(place)
        drawing.arrow([view((0, 0, 0)), (px, py)], "blue")
        drawing.circle(px, py, 5.5, "blue")
        drawing.text(px - 12, py + 2 + side, name, SMALL, "end", "blue")
        lx, ly = view(times(1.05, turn(angle, x, z)))
        drawing.text(lx + 2, ly - 9, label, colour="blue")
    drawing.arrow([view(times(1.5, turn(a, x, z))) for a in range(56, 76, 2)], "blue")
    lx, ly = view(times(1.5, turn(68, x, z)))
    drawing.text(lx - 10, ly - 12, "flight", SMALL, "end", "blue")
    for i, line in enumerate(("*X*, *Y*, *Z* inertial:", "mean equator and", "equinox of J2000")):
        drawing.text(366, 62 + 20*i, line, SMALL, "start")
    for i, line in enumerate(("*x*′, *y*′, *z*′ fixed to", "the Earth; *x*′ in the", "meridian of Greenwich")):
        drawing.text(366, 130 + 20*i, line, SMALL, "start", "green")


def draw_satellites(drawing):
    """Both satellites, seen along the orbit normal; the angle between them, twice the pitch, is enlarged."""
    drawing.text(16, 448, "**Body axes and orbit-local axes**, seen along *N*", anchor="start")
    pitch, level, half = 18, 602, 140
    radius = half/math.sin(math.radians(pitch))
    cx, cy = WIDTH/2, level + radius*math.cos(math.radians(pitch))
    surface = radius - 150

    def along(r, angle):
        return cx + r*math.sin(math.radians(angle)), cy - r*math.cos(math.radians(angle))

    earth = [along(surface, a) for a in range(-45, 46)]
    seen = [p for p in earth if -20 <= p[0] <= WIDTH + 20]
    drawing.path(seen + [(WIDTH + 20, 900), (-20, 900)], "thin box s-soft", closed=True)
    drawing.path([along(radius, a/2) for a in range(-40, 41)], "thin s-soft")
    drawing.path([(cx - half, level), (cx + half, level)], "thin dashed s-soft")
    for side, name, axes in ((-1, "2", 1), (1, "1", -1)):
        px, angle, outwards = cx + side*half, side*pitch, "start" if side > 0 else "end"
        outline = [(px - 52, level - 13), (px + 52, level - 13), (px + 52, level + 13), (px - 52, level + 13)]
        drawing.path(outline, "frame box s-soft", closed=True)
        drawing.path([(px, level), along(surface, angle)], "thin dashed s-soft")
        drawing.arrow([(px, level), along(radius + 92, angle)], "green")
        tx, ty = px + 112*math.cos(math.radians(angle)), level + 112*math.sin(math.radians(angle))
        drawing.arrow([(px, level), (tx, ty)], "green")
        rx, ry = along(radius + 92, angle)
        drawing.text(rx + 12*side, ry + 6, "*R*", BODY, outwards, "green")
        drawing.text(tx if side < 0 else tx + 10, ty - 8 if side < 0 else ty + 8, "*T*", colour="green")
        drawing.arrow([(px, level), (px + 86*axes, level)], "blue", "bold")
        drawing.arrow([(px, level), (px, level + 92)], "blue", "bold")
        drawing.text(px + 78*axes, level + 23, f"*x*_{{{name}}}", colour="blue")
        drawing.text(px + 18*side, level + 92, f"*z*_{{{name}}}", colour="blue")
        drawing.circle(px, level, 8.5, "frame paper s-blue")
        if side < 0:
            drawing.circle(px, level, 2.8, "blue")
        else:
            drawing.path([(px - 5.5, level - 5.5), (px + 5.5, level + 5.5)], "line s-blue")
            drawing.path([(px - 5.5, level + 5.5), (px + 5.5, level - 5.5)], "line s-blue")
        drawing.text(px + 20*side, level + 34, f"*y*_{{{name}}}", BODY, outwards, "blue")
        drawing.text(px + 20*side, level + 54, "= *N*" if side > 0 else "= −*N*", SMALL, outwards, "blue")
    drawing.path([(cx - half + 88*math.cos(math.radians(a)), level - 88*math.sin(math.radians(a)))
                  for a in range(0, pitch + 1)], "thin s-red")
    drawing.path([(cx + half + 88*math.cos(math.radians(a)), level + 88*math.sin(math.radians(a)))
                  for a in range(0, pitch + 1)], "thin s-red")
    drawing.path([(cx + half + 52, level), (cx + half + 104, level)], "thin dashed s-soft")
    drawing.text(cx - half + 116, level - 6, "1°", SMALL, "start", "red")
    drawing.text(cx + half + 93, level + 19, "1°", SMALL, "start", "red")
    drawing.text(cx - half - 18, level - 22, "back", SMALL, "end")
    drawing.text(cx + half + 18, level - 22, "front", SMALL, "start")
    drawing.arrow([along(radius + 38, a/2) for a in range(-7, 10)], "ink")
    drawing.text(cx, level - radius*(1 - math.cos(math.radians(pitch))) - 48, "flight", SMALL)
    drawing.text(cx, level + 17, "line of sight", SMALL, colour="soft")
    drawing.text(cx, 784, "Earth", SMALL, colour="soft")
    drawing.text(cx, 806, "*R* radial, *T* along track, *N* = *R* × *T* into the page.", SMALL)
    drawing.text(cx, 826, "Pitch, separation and heights not to scale.", SMALL, colour="soft")


def radial_vector():
    drawing = Drawing(
        "radial_vector", "Radial unit vector and offset d in body axes",
        "Above: the satellite, a prism with a trapezoid as cross-section, with the body axes x, y, z at its centre "
        "of mass (COM), the vector R_c from the Earth's centre to the COM, the unit vector c along it and the "
        "angles alpha_1, alpha_2, alpha_3 between c and the axes. Below: the offset d from the COM to the "
        "proof-mass centre (PMC), its components, and the parallel axes at the PMC.", 772)
    draw_radial_vector(drawing)
    drawing.path([(0, 452), (WIDTH, 452)], "thin s-rule")
    draw_offset(drawing)
    return drawing


def body(v):
    """Body axes in a space whose third axis is up: z of the body is down."""
    return (v[0], -v[1], -v[2])


def draw_radial_vector(drawing):
    """The vertical in body axes; it stands far from -z here, so that the angles can be seen."""
    drawing.text(16, 28, "**Radial unit vector** *c*", anchor="start")
    view = View((250, 190), 82, -62, 24)
    length, height, bottom, top = 3.122, 0.720, 1.942, 0.693
    corner = {(i, j, k): body((i*length/2, j*(bottom if k > 0 else top)/2, k*height/2))
              for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)}
    for face in (((1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)),
                 ((-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1)),
                 ((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1))):
        drawing.path([view(corner[c]) for c in face], "thin box s-rule", closed=True)
    for a, b in (((-1, -1, 1), (1, -1, 1)), ((-1, -1, 1), (-1, 1, 1)), ((-1, -1, 1), (-1, -1, -1))):
        drawing.path([view(corner[a]), view(corner[b])], "thin dashed s-rule")
    com = body((0, 0, 0))
    c = unit((-0.34, 0.10, -0.90))
    earth = times(-2.55, c)
    ex, ey = view(body(earth))
    drawing.circle(ex, ey, 46, "thin box s-soft")
    drawing.circle(ex, ey, 2.5, "ink")
    drawing.text(ex + 54, ey + 22, "Earth", SMALL, "start", "soft")
    drawing.arrow([(ex, ey), view(body(times(0.02, earth)))])
    lx, ly = view(body(times(0.62, earth)))
    drawing.text(lx + 12, ly + 6, "*R*_{c}", anchor="start")
    for axis, size, name, dx, dy, anchor in (((1, 0, 0), 2.25, "x", 10, 6, "start"),
                                             ((0, 1, 0), 2.15, "y", -10, 10, "end"),
                                             ((0, 0, 1), 1.45, "z", -12, 4, "end")):
        tip = view(body(times(size, axis)))
        drawing.arrow([view(com), tip], "blue", "bold")
        drawing.text(tip[0] + dx, tip[1] + dy, f"*{name}*", anchor=anchor, colour="blue")
    drawing.arrow([view(com), view(body(times(1.45, c)))], "red", "bold")
    tip = view(body(times(1.45, c)))
    drawing.text(tip[0] - 10, tip[1] + 4, "*c*", anchor="end", colour="red")
    for axis, radius, name, at, dx, dy in (((1, 0, 0), 0.95, "1", 0.45, 6, -8),
                                           ((0, 1, 0), 1.20, "2", 0.50, -14, -2),
                                           ((0, 0, 1), 0.62, "3", 0.42, 14, 8)):
        points = arc_between(c, axis, radius)
        drawing.path([view(body(p)) for p in points], "thin s-green")
        px, py = view(body(points[int(40*at)]))
        drawing.text(px + dx, py + dy, f"*α*_{{{name}}}", SMALL, colour="green")
    drawing.circle(*view(com), 4.5, "ink")
    for i, line in enumerate(("*c* = *R*_{c} / |*R*_{c}|", "*c*_{i} = cos *α*_{i}", "in flight *α*_{3} ≈ 179°")):
        drawing.text(385, 72 + 24*i, line, BODY if i < 2 else SMALL, "start")


def draw_offset(drawing):
    """The offset with its components."""
    drawing.text(16, 480, "**Offset** *d* **from the COM to the PMC**", anchor="start")
    view = View((122, 572), 300, -62, 24)
    d = (0.40, -0.40, 0.40)     # mm, the report's back satellite
    corners = [(0, 0, 0), (d[0], 0, 0), (d[0], d[1], 0), d]
    drawing.path([view(body(corner)) for corner in corners], "thin dashed s-red")
    for i, (name, dx, dy) in enumerate((("x", 2, -12), ("y", -14, -6), ("z", 14, -14))):
        (x0, y0), (x1, y1) = view(body(corners[i])), view(body(corners[i + 1]))
        drawing.text((x0 + x1)/2 + dx, (y0 + y1)/2 + dy, f"*d*_{{{name}}}", SMALL, colour="red")
    for origin, colour, sizes in (((0, 0, 0), "blue", (0.80, 0.55, 0.40)), (d, "soft", (0.45, 0.40, 0.28))):
        for axis, size, name, dx, dy, anchor in (((1, 0, 0), sizes[0], "x", 9, 6, "start"),
                                                 ((0, 1, 0), sizes[1], "y", -8, 12, "end"),
                                                 ((0, 0, 1), sizes[2], "z", -9, 6, "end")):
            tip = view(body(plus(origin, times(size, axis))))
            drawing.arrow([view(body(origin)), tip], colour, "bold" if colour == "blue" else "line")
            drawing.text(tip[0] + dx, tip[1] + dy, f"*{name}*", anchor=anchor, colour=colour)
    drawing.arrow([view(body((0, 0, 0))), view(body(times(0.97, d)))], "red", "bold")
    mx, my = view(body(times(0.5, d)))
    drawing.text(mx - 8, my + 18, "*d*", anchor="end", colour="red")
    ox, oy = view(body((0, 0, 0)))
    drawing.circle(ox, oy, 5, "ink")
    drawing.text(ox - 10, oy - 10, "COM", SMALL, "middle")
    px, py = view(body(d))
    drawing.circle(px, py, 5, "ink")
    drawing.text(px + 12, py - 8, "PMC", SMALL, "start")
    drawing.text(385, 512, "*J* is about the COM,", SMALL, "start")
    drawing.text(385, 532, "*J*_{p} about the PMC,", SMALL, "start")
    drawing.text(385, 552, "(2-18)", SMALL, "start")


class Chart:
    """Boxes of a flow chart, one below the other."""

    def __init__(self, drawing, middle, width):
        self.drawing, self.middle, self.width = drawing, middle, width
        self.bottom, self.level = 14, {}

    def add(self, name, text, kind="step", colour="ink", label="", gap=22):
        """The next box, with an arrow from the one above; level[name] keeps the height of its middle."""
        top = self.bottom
        if self.level:
            top += gap
            self.drawing.arrow([(self.middle, self.bottom), (self.middle, top)])
            if label:
                self.drawing.text(self.middle + 8, top - gap/2 + 4, label, SMALL, "start")
        self.bottom = self.drawing.box(self.middle, top, self.width, text, kind, colour)
        self.level[name] = (top + self.bottom)/2

    def beside(self, name, middle, width, text, kind, colour, label="", into=False):
        """A box at the height of another, with an arrow from that or into it."""
        height = self.level[name]
        self.drawing.box(middle, height - box_height(text)/2, width, text, kind, colour)
        ends = [(self.middle + self.width/2, height), (middle - width/2 + (3 if kind == "data" else 0), height)]
        self.drawing.arrow(ends[::-1] if into else ends)
        if label:
            self.drawing.text((ends[0][0] + ends[1][0])/2, height - 7, label, SMALL)

    def back(self, start, end, x, label):
        """An arrow from the left side of one box to that of another, by way of x."""
        left = self.middle - self.width/2
        y0, y1 = self.level[start], self.level[end]
        self.drawing.arrow([(left, y0), (x, y0), (x, y1), (left, y1)])
        self.drawing.text(left - 6, y0 - 8, label, SMALL, "end")

    def done(self):
        """The drawing, as high as the chart."""
        self.drawing.height = round(self.bottom + 14)
        return self.drawing


def star_camera():
    drawing = Drawing(
        "star_camera", "Flow chart of the star camera's simulation",
        "For every frame of each head: the true attitude gives the camera's axes; the first 20 catalogue stars "
        "in the field of view are its stars; with fewer than two it is refused. This is the same in every run. "
        "In every run noise is added across each line of sight, and QUEST gives the quaternion from the inertial "
        "to the camera frame and its covariance. After the last frame the quaternions stand in the observation "
        "set.")
    chart, side = Chart(drawing, 206, 316), 460
    chart.add("frame", "**Next frame** at *t*_{k}, head 1 or 2\n~every 0.5 s, 120 frames a head", "end")
    chart.add("attitude", "True attitude *q*(*t*_{k}) of the arc (2-31)")
    chart.add("camera", "Camera axes: *A* = *M*_{mount} *M*(*t*_{k});\n~boresight, field of view 22° × 16°")
    chart.add("stars", "The first 20 stars in the field:\n~*V*_{i} inertial, *W*_{i} = *A V*_{i} camera frame")
    chart.beside("stars", side, 140, "Catalogue:\n~4616 stars\n~1.0 to 6.0 mag", "data", "blue", into=True)
    chart.add("enough", "Two stars at least?", "choice")
    chart.beside("enough", side, 120, "Refused", "end", "red", "no")
    line = chart.bottom + 33
    chart.add("noise", "Noise across each line of sight:\n~*σ* = 3.2″, of catalogue (1″) and image (3″)", gap=72)
    chart.beside("noise", side, 140, "~Random\n~numbers of\n~the run", "data", "blue", into=True)
    drawing.path([(48, line), (WIDTH - 16, line)], "thin dashed s-soft")
    drawing.text(220, line - 8, "yes", SMALL, "start")
    drawing.text(WIDTH - 16, line - 8, "above: found once", SMALL, "end", "soft")
    drawing.text(WIDTH - 16, line + 19, "below: anew in every run", SMALL, "end", "soft")
    chart.add("quest", "**QUEST**: *K* of (3-15) from *V*_{i}, *W*_{i};\n~its largest eigenvalue, the eigenvector")
    chart.add("result", "Quaternion, inertial to camera;\ncovariance *P* (3-21)", "data", "blue")
    chart.beside("result", side, 140, "~Mean of *P*:\n~noise level that\n~operators know", "data", "blue")
    chart.add("last", "Last frame?", "choice")
    chart.back("last", "frame", 22, "no")
    chart.add("end", "**Observation set**", "end", label="yes")
    return chart.done()


def batch_processor():
    drawing = Drawing(
        "batch_processor", "Flow chart of the batch processor",
        "From observations and a first guess the nominal trajectory and its transition matrix are integrated. "
        "Every observation gives partials, residual and weight, which are accumulated in the normal equations. "
        "A singular normal matrix is refused. Its solution corrects the nominal state. This is repeated until "
        "every correction is negligible, at most 20 times; a linear problem is solved once.")
    chart, side = Chart(drawing, 208, 318), 466
    chart.add("start", "**Observations**, first guess *X*^{∗}(*t*_{0})", "end")
    chart.add("integrate", "Integrate the nominal trajectory *X*^{∗}(*t*)\n"
              "and the transition matrix Φ(*t*, *t*_{0}):\n~(4-45), (4-47); step 0.1 s")
    chart.add("rows", "For each observation *i* = 1 … *m*:\n~*H*_{i} = *H̃*_{i} Φ(*t*_{i}, *t*_{0}), (4-49);\n"
              "~*y*_{i} = observed − computed; weight *W*_{i}")
    chart.add("sums", "Accumulate the normal equations:\n"
              "~*N* = Σ *H*_{i}^{T} *W*_{i} *H*_{i},  *b* = Σ *H*_{i}^{T} *W*_{i} *y*_{i}")
    chart.add("singular", "*N* singular?", "choice")
    chart.beside("singular", side, 136, "**Refused**\n~names what is\n~undetermined", "end", "red", "yes")
    chart.add("solve", "Solve *N x̂* = *b*\n~(Cholesky, *N* scaled to unit diagonal)", label="no")
    chart.add("update", "Correct the state: *X*^{∗}(*t*_{0}) + *x̂*\n~(small angles turn *q*; *q* normalised)")
    chart.add("converged", "Linear problem, or every\n~|*x̂*_{j}| ≤ 10^{−9} of its typical size?", "choice")
    chart.beside("converged", side, 136, "**Solution**\n~*X*^{∗}(*t*_{0}), *N*^{−1},\n~residuals", "end", "green", "yes")
    chart.add("often", "20 times already?", "choice", label="no")
    chart.back("often", "integrate", 22, "no")
    chart.add("end", "**Solution**, marked as not converged", "end", "red", "yes")
    return chart.done()


def simulation():
    drawing = Drawing(
        "simulation", "Flow chart of the whole simulation",
        "A case gives the truth. Orbit and attitude are integrated once. The accelerometer is sampled every "
        "0.1 s, the star camera every 0.5 s and the magnetometer every second, with noise that is drawn anew in "
        "every run. The observation set, with what the operator knows, is preprocessed and goes to one of the "
        "estimators. The estimate is compared with the true offset; after many runs this gives the errors of a "
        "Monte Carlo. A trim moves the mass by the estimate, and the calibration begins anew.")
    middle = WIDTH/2
    chart = Chart(drawing, middle, 420)
    chart.add("case", "**Case**: satellite with its offset *d*, orbit,\ntorque rods, environment, instruments",
              "data", "blue")
    chart.add("integrate", "Integrate orbit and attitude (2-31)\n"
              "~forces and torques of Table 5.1; Runge-Kutta 7(8), 0.1 s")
    chart.add("arc", "**True arc** at *t*_{k} = 0, 0.1 … 60 s:\n"
              "*r*, *v*, *ω*, *q*, d*ω*/d*t*, forces, torques, *B*", "data", "blue")

    def side_by_side(boxes, width, first, gap, last):
        """Boxes beside each other, with arrows from the one above and lines to the next; gives top and bottom."""
        top = chart.bottom + gap
        for x, text in boxes:
            start, turning = (middle, chart.bottom), chart.bottom + first
            drawing.arrow([start, (x, top)] if x == middle else [start, (middle, turning), (x, turning), (x, top)])
            bottom = drawing.box(x, top, width, text)
            drawing.path([(x, bottom), (x, bottom + last), (middle, bottom + last)])
        chart.bottom = bottom + last
        return top, bottom

    top, bottom = side_by_side(
        ((110, "**Accelerometer**\n~0.1 s\n~*a* at the PMC (3-7);\n~scale factors, bias;\n~coloured noise"),
         (270, "**Star camera**\n~0.5 s\n~stars of each head;\n~their noise;\n~QUEST"),
         (430, "**Magnetometer**\n~1 s\n~*B* in body axes;\n~bias;\n~white noise")), 150, 14, 58, 22)
    drawing.path([(28, top - 30), (512, top - 30), (512, bottom + 10), (28, bottom + 10)], "thin dashed s-soft",
                 closed=True)
    drawing.text(350, top - 10, "anew in every run", SMALL, colour="soft")
    instruments = (top + bottom)/2
    chart.add("set", "**Observation set**: *A*_{out}, quaternions, *B*,\n~the orbit by GPS, and what the operator\n"
              "~knows: *J*_{p}, *m*(*t*), noise levels, first guess", "data", "blue", gap=14)
    chart.add("preprocess", "Preprocessing: body axes, signs, gaps;\n"
              "~attitude interpolated to 0.1 s, torque to 0.05 s")
    side_by_side(((161, "The report’s estimators\n~ASSEST, ASCFEST,\n~ASCREST"),
                  (379, "optimal, sequential\n~whitened samples\n~at their own epochs")), 210, 12, 26, 12)
    chart.add("estimate", "**Estimate** of *d*, its covariance", "data", "green")
    chart.add("error", "Compare with the true *d*")
    chart.add("again", "Another run?", "choice")
    y, right = chart.level["again"], middle + chart.width/2
    drawing.arrow([(right, y), (528, y), (528, instruments), (514, instruments)])
    drawing.text(right + 6, y - 8, "yes", SMALL, "start")
    chart.add("trim", "Trim: move the mass by the estimate?", "choice", label="no")
    chart.back("trim", "case", 12, "yes")
    chart.add("end", "**RMS of the errors**, and what the trim left", "end", label="no")
    return chart.done()


def main():
    check = "--check" in sys.argv[1:]
    stale = []
    for draw in (frames, radial_vector, star_camera, batch_processor, simulation):
        drawing = draw()
        text = drawing.svg()
        for path in (FOLDER / f"{drawing.name}.svg", PAGES / f"{drawing.name}.svg"):
            if path.exists() and path.read_text(encoding="utf-8") == text:
                continue
            stale.append(path)
            if not check:
                path.write_text(text, encoding="utf-8")
    for path in stale:
        print(("out of date: " if check else "written: ") + str(path.relative_to(ROOT)))
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
