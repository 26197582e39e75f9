"""The film at the head of the README and of the site: ``make film`` writes docs/didymos.gif.

On the left are two days of Didymos and Dimorphos after DART, seen from a fixed direction; on the right a hundred days
of Dimorphos' libration and of the orbit's eccentricity, with those two days marked.
"""

import io
from pathlib import Path

import fullbody
import matplotlib as mpl
from fullbody.plots.scene import draw_body, set_range
from matplotlib.figure import Figure
from PIL import Image

DAYS = 100.0
#: The first day of the film; the number of pictures; and, in steps of ten minutes, the time between two pictures and
#: the length of the trail behind Dimorphos.
FIRST_DAY, PICTURES, STEP, TRAIL = 20, 60, 5, 60
COLOURS = {"roll": "#D55E00", "yaw": "#0072B2"}


def main() -> None:
    """Make the film."""
    system, state = fullbody.systems.didymos_after_dart(tilt=1e-3, units=True)
    run = system.integrate(state, f"{DAYS} day", output="0.5 h")
    film = system.integrate(
        run[48 * FIRST_DAY], f"{FIRST_DAY * 1440 + 10 * (TRAIL + PICTURES * STEP)} min", output="10 min"
    )
    mpl.rcParams.update({"font.size": 8.0})
    figure = Figure(figsize=(9.0, 4.0))
    scene = figure.add_axes((-0.04, -0.12, 0.58, 1.24), projection="3d")
    panels = [figure.add_axes((0.62, bottom, 0.365, 0.33)) for bottom in (0.58, 0.12)]
    figure.text(0.03, 0.93, "Didymos and Dimorphos after DART", fontsize=11)
    clock = figure.text(0.03, 0.87, "", fontsize=9, color="0.3")
    draw_history(run, panels)
    centres = film.position.value - film.position.value[:, :1]
    set_range(scene, film, centres, [0, 1])
    scene.set_axis_off()
    scene.view_init(elev=24, azim=-60)
    path = Path(__file__).with_name("didymos.gif")
    pictures: list[Image.Image] = []
    for k in range(TRAIL, len(film) - 1, STEP):
        day = film.time[k].to_value("day")
        clock.set_text(f"day {day:.1f}")
        artists = scene.plot(*centres[k - TRAIL : k + 1, 1].T, color="#E69F00", linewidth=1.2)
        for body, name in enumerate(system.names):
            artists += draw_body(scene, film, body, centres[k, body], film.attitude[k, body], name, {}, mesh=(31, 16))
        marks = [ax.axvline(day, color="0.2", linewidth=0.8) for ax in panels]
        pictures.append(picture(figure))
        for artist in (*artists, *marks):
            artist.remove()
    write(pictures, path)
    print(f"{path.name}: {path.stat().st_size / 1e6:.2f} MB")


def picture(figure: Figure) -> Image.Image:
    """Return the figure as a picture in colours."""
    written = io.BytesIO()
    figure.savefig(written, format="png", dpi=90)
    return Image.open(written).convert("RGB")


def write(pictures: list[Image.Image], path: Path) -> None:
    """Write a film with one palette of 64 colours, taken from six of its pictures, which keeps the file small."""
    width, height = pictures[0].size
    sample = Image.new("RGB", (width, 6 * height))
    for k in range(6):
        sample.paste(pictures[k * len(pictures) // 6], (0, k * height))
    palette = sample.quantize(64, dither=Image.Dither.NONE)
    first, *others = (picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures)
    first.save(path, save_all=True, append_images=others, duration=80, loop=0, optimize=True)


def draw_history(run: fullbody.Run, panels: list) -> None:
    """Draw Dimorphos' roll and yaw in its orbit's frame, and the eccentricity, against days."""
    days = run.time.to_value("day")
    angles = fullbody.observables.roll_pitch_yaw(run).to_value("deg")
    for name, column in (("yaw", 2), ("roll", 0)):
        panels[0].plot(days, angles[:, column], color=COLOURS[name], linewidth=0.4)
        panels[0].plot([], [], color=COLOURS[name], label=name)
    panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, borderaxespad=0.1)
    panels[0].set_title("Dimorphos in its orbit's frame", loc="left", fontsize=9)
    panels[0].set_ylabel("degrees")
    panels[1].plot(days, run.elements().e, color="#009E73", linewidth=0.4)
    panels[1].set_title("osculating eccentricity", loc="left", fontsize=9)
    panels[1].set_xlabel("days")
    for ax in panels:
        ax.set_xlim(0.0, DAYS)
        ax.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    main()
