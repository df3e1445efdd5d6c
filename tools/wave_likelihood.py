#!/usr/bin/env python3
"""What the report's published numbers say about the density wave, by likelihood.

    tools/wave_likelihood.py [--program build/bin/gracecg] [--amplitude 0.0072] [--period 19.9] [--check RUNS]
                             [--no-maps] [--printed]

CSR-TM-00-01 includes "short-period density perturbations" and defines none. gracecg has a wave of one amplitude (relative to
the model's density) and one period, whose phase is drawn for every run. This looks for both in everything that is published:

- the 72 RMS values of Tables 6.1 and 6.2. The errors of a run are e = b + A (s cos p + c sin p) + n, with n normal, its
  covariance and the bias b the program's, s and c its answer to a wave, p random. The likelihood is that of the three sums of
  squares over 15 runs together, whose axes are correlated (front 1: x and y by -0.997), by the saddlepoint approximation from
  their joint generating function (Daniels, Ann. Math. Stat. 25, 1954); no sum is taken as a chi-square, no two axes as
  independent. The four algorithms are taken as four sets of runs: of the same runs their values would agree to five digits;
- the axis windows and tick marks of the 18 curves of Figures 5.2, 5.3, 5.6, 5.7 that are in proportion to the density. The phase of
  a figure is unknown, the same for all curves of a satellite. A window that is met has the likelihood 1 - MISS, one that is
  missed MISS, which is about what the wave leaves unexplained in any case; so they are a count, made comparable, not a model of
  how those curves were drawn.

Prints maps over amplitude and period, what each piece asks for, some settings side by side, and of one setting the ratios of
published values to theory by axis and by case, the entries that stay outside, and how many of 72 a correct theory leaves inside
their band: the axes of 24 x 15 runs drawn together. Two minutes. Needs numpy.
"""
import argparse
import csv
import json
import pathlib
import re
import subprocess
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
CASES = ("front-1", "front-2", "front-3", "back-1", "back-2", "back-3")
ALGORITHMS = ("assest-fde", "assest-rde", "ascfest", "ascrest")
RUNS = 15                                   # of a published value
LOWEST, HIGHEST = 0.646, 1.354              # published/theory of 95 % of normal errors: chi-square with 15 degrees of freedom
PROBE = 0.003                               # amplitude of the computed answers, which are linear
AMPLITUDES = np.arange(0, 0.01201, 0.0004)
PERIODS = np.array([8, 9, 10, 11, 11.5, 12, 12.5, 13, 14, 15, 15.4, 15.5, 15.6, 16, 17, 18, 19, 19.8, 19.9, 20, 20.2, 21, 22, 23, 24,
                    26, 28, 30, 31, 35, 40, 50, 60])
SETTINGS = ((0, 12), (0.003, 12), (0.0064, 15.5), (0.0072, 19.9), (0.0076, 20), (0.0092, 31))      # side by side
PHASES = 2*np.pi*np.arange(24)/24
DENSITY_CURVES = ("drag", "non_gravitational", "torque_aero")
WITHOUT_NOISE = "accelerometer-noise,star-camera-noise,magnetometer-noise"
TOLERANCE, MISS = 0.05, 0.25                # of a window's width, as `verify`; chance that a window is missed for other reasons


class Program:
    """The program, and case files made from its built-in cases, in a folder of its own."""

    def __init__(self, path, folder, end=""):
        self.path, self.folder, self.end = str(pathlib.Path(path).resolve()), folder, end
        self.text = {case: self.run("cases", "show", case + end) for case in CASES}

    def run(self, *words):
        return subprocess.run([self.path, *words], cwd=self.folder, check=True, capture_output=True, text=True).stdout

    def case_file(self, case, name, **settings):
        """A case with other settings of the group `atmosphere`."""
        before, group, after = self.text[case].partition("&atmosphere")
        for key, value in settings.items():
            after, found = re.subn(rf"^( *{key} = )[^ ]+", rf"\g<1>{value}", after, count=1, flags=re.M)
            assert found == 1, key
        (self.folder/name).write_text(before + group + after)
        return name

    def offsets(self, names, runs, *words):
        """Estimates of d, mm: one array of (runs, 3) for each case file."""
        self.run("montecarlo", *names, "--algorithms", "assest-fde", "--runs", str(runs), "--runs-out", "runs.csv", *words)
        with open(self.folder/"runs.csv") as lines:
            rows = [[float(row[f"d{axis}_mm"]) for axis in "xyz"] for row in csv.DictReader(lines)]
        return np.array(rows).reshape(len(names), runs, 3)


class Theory:
    """Covariance of the noise, bias, and answers to waves: one for each case, mm."""

    def __init__(self, program):
        self.program = program
        still = [program.case_file(case, f"{case}-still.nml", density_wave_amplitude=0) for case in CASES]
        self.truth = np.array([[float(x) for x in re.search(r"offset_mm = ([^!]*)", program.text[case])[1].split(",")]
                               for case in CASES])
        self.still = program.offsets(still, 1, "--without", WITHOUT_NOISE)[:, 0]
        self.bias = self.still - self.truth
        rows = csv.DictReader(program.run("montecarlo", *still, "--runs", "1", "--algorithms", "assest-fde", "--format",
                                          "csv").splitlines())
        sigma = np.sqrt(np.array([float(row["predicted_mm"]) for row in rows]).reshape(-1, 3)**2 - self.bias**2)
        self.covariance = np.empty((len(CASES), 3, 3))
        for i, case in enumerate(CASES):            # the program prints correlations with an estimate only
            program.run("simulate", still[i], "--out", case)
            estimate = json.loads(program.run("estimate", case, "--algorithm", "assest-fde", "--format", "json"))
            printed = np.array(estimate["covariance"]["matrix"])[:3, :3]
            scale = sigma[i]/np.sqrt(np.diag(printed))
            self.covariance[i] = printed*np.outer(scale, scale)
        self.answers = {}

    def answer(self, period):
        """Of each case to a wave of amplitude 1 that begins as sine and as cosine: (cases, 2, 3), mm."""
        if period not in self.answers:
            d = [self.program.offsets([self.program.case_file(
                case, f"{case}-wave.nml", density_wave_amplitude=PROBE, density_wave_period=period, density_wave_phase_deg=phase,
                density_wave_random=".false.") for case in CASES], 1, "--without", WITHOUT_NOISE)[:, 0] for phase in (0, 90)]
            self.answers[period] = np.stack([(phase - self.still)/PROBE for phase in d], axis=1)
        return self.answers[period]

    def means(self, amplitude, period):
        """Mean errors of each case and phase: (cases, phases, 3), mm."""
        sine, cosine = self.answer(period).transpose(1, 0, 2)
        waves = np.cos(PHASES)[:, None]*sine[:, None] + np.sin(PHASES)[:, None]*cosine[:, None]
        return self.bias[:, None] + amplitude*waves

    def rms(self, amplitude, period):
        """Predicted RMS errors: (cases, 3), mm."""
        mean_square = np.mean(self.means(amplitude, period)**2, axis=1)
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2) + mean_square)

    def draw(self, amplitude, period, reports, generator):
        """RMS values of whole reports: (reports, cases, algorithms, 3), mm."""
        shape = (reports, len(ALGORITHMS), RUNS)
        drawn = np.empty((reports, len(CASES), len(ALGORITHMS), 3))
        for i, mean in enumerate(self.means(amplitude, period)):
            errors = generator.normal(size=shape + (3,)) @ np.linalg.cholesky(self.covariance[i]).T
            errors += mean[generator.integers(len(PHASES), size=shape)]
            drawn[:, i] = np.sqrt(np.mean(errors**2, axis=2))
        return drawn


def published_values():
    """RMS values: (cases, algorithms, 3), mm, the misprint mended as in src/studies/published.f90."""
    lines = [line for line in (ROOT/"data/report_rms_tables.csv").read_text().splitlines() if not line.startswith("#")]
    rows = [[float(row[a.replace("-", "_")]) for a in ALGORITHMS] for row in csv.DictReader(lines)]
    values = np.array(rows).reshape(len(CASES), 3, len(ALGORITHMS)).transpose(0, 2, 1)
    values[values == 0.01112] = 0.1112
    return values


def inside(published, rms):
    """Which values lie in the band of 95 % about theory."""
    ratio = published/rms[:, None]
    return (ratio >= LOWEST) & (ratio <= HIGHEST)


def log_density(rms, covariance, means):
    """Log density of the sums of squares of RUNS errors e = m + n, n normal, m one of `means` with equal chance.

    K(t) = RUNS log mean_m E exp(sum_i t_i e_i^2); at the saddlepoint grad K = q, and the density is
    exp(K - t.q)/sqrt((2 pi)^3 det K''). Under the tilted law e is normal with S = (C^-1 - 2 T)^-1 and mean S C^-1 m, from which
    gradient and second derivatives follow. `rms` (3), `covariance` (3, 3), `means` (phases, 3), in one unit."""
    unit = rms
    c, means, q = covariance/np.outer(unit, unit), means/unit, RUNS*np.ones(3)
    inverse = np.linalg.inv(c)
    half_log_det = np.linalg.slogdet(c)[1]/2
    forces = means @ inverse
    constants = np.sum(forces*means, axis=1)/2

    def cumulants(t):
        precision = inverse - 2*np.diag(t)
        try:
            root = np.linalg.cholesky(precision)
        except np.linalg.LinAlgError:
            return None                             # beyond the edge of convergence
        s = np.linalg.inv(precision)
        mu = forces @ s
        exponents = np.sum(forces*mu, axis=1)/2 - constants
        top = exponents.max()
        weights = np.exp(exponents - top)
        k = np.log(weights.mean()) + top - half_log_det - np.sum(np.log(np.diag(root)))
        weights /= weights.sum()
        squares = np.diag(s) + mu**2
        gradient = weights @ squares
        second = 2*s**2 + 4*s*(mu.T*weights @ mu) + (squares.T*weights @ squares) - np.outer(gradient, gradient)
        return RUNS*k, RUNS*gradient, RUNS*second

    t, now = np.zeros(3), cumulants(np.zeros(3))
    for _ in range(200):
        k, gradient, second = now
        step = np.linalg.solve(second, q - gradient)
        if (q - gradient) @ step < 1e-9:
            return k - t @ q - np.linalg.slogdet(second)[1]/2 - 1.5*np.log(2*np.pi) - 2*np.sum(np.log(unit))
        for shorter in 0.5**np.arange(40):
            trial = cumulants(t + shorter*step)
            if trial and trial[0] - (t + shorter*step) @ q <= k - t @ q + 1e-12*(abs(k) + abs(t @ q)):
                break
        t, now = t + shorter*step, trial
    raise ArithmeticError("no saddlepoint")


def tables_log_likelihood(theory, published, amplitude, period, used=None):
    """Sum over the cases and algorithms that are used (all): 24 sets of three correlated axes."""
    means = theory.means(amplitude, period)
    return sum(log_density(published[i, a], theory.covariance[i], means[i]) for i in range(len(CASES))
               for a in range(len(ALGORITHMS)) if used is None or used[i, a])


def independent_log_likelihood(theory, published, amplitude, period):
    """The same for chi-squares with 15 degrees of freedom and independent axes, for comparison."""
    ratio = (published/theory.rms(amplitude, period)[:, None])**2
    return np.sum(RUNS/2*(np.log(ratio) - ratio))


class Windows:
    """The density's curves of case 1 without a wave, and the printed axes."""

    def __init__(self, program):
        names = [program.case_file(case, f"{case}.nml", density_wave_amplitude=0) for case in ("front-1", "back-1")]
        program.run("verify", *names, "--out", "curves")
        self.scale = float(re.search(r"density_scale = (\S+)", program.text["front-1"])[1])
        self.curves = {}
        for satellite in ("front", "back"):
            lines = [line for line in (program.folder/f"curves/verify_{satellite}-1{program.end}.csv").read_text().splitlines()
                     if not line.startswith("#")]
            rows = list(csv.DictReader(lines))
            columns = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
            self.time = columns["time_s"]
            for axis in "xyz":
                drag = columns[f"drag_{axis}_m_s2"]
                torque = columns[f"torque_aero_{axis}_n_m"]
                self.curves[satellite, "drag", axis] = drag, 0*drag
                self.curves[satellite, "non_gravitational", axis] = drag, columns[f"non_gravitational_{axis}_m_s2"] - drag
                self.curves[satellite, "torque_aero", axis] = torque, 0*torque
        lines = [line for line in (ROOT/"data/report_figure_windows.csv").read_text().splitlines() if not line.startswith("#")]
        self.axes = [(row["satellite"], row["quantity"], row["axis"], float(row["low"]), float(row["high"]), float(row["step"]))
                     for row in csv.DictReader(lines) if row["quantity"] in DENSITY_CURVES]

    def met(self, amplitude, period, factor=1.0):
        """Of every axis and phase, inside and on the ticks, with `factor` times the density: (axes, phases), twice."""
        wave = amplitude/(self.scale*factor)*np.sin(2*np.pi*self.time/period + PHASES[:, None])
        inside, ticks = [], []
        for satellite, quantity, axis, low, high, step in self.axes:
            air, rest = self.curves[satellite, quantity, axis]
            curve = factor*air*(1 + wave) + rest
            least, greatest = curve.min(axis=1), curve.max(axis=1)
            inside.append(np.maximum(low - least, greatest - high) <= TOLERANCE*(high - low))
            ticks.append((least >= low) & (least < low + step) & (greatest <= high) & (greatest > high - step))
        return np.array(inside), np.array(ticks)

    def log_likelihood(self, amplitude, period, factor=1.0):
        """Of windows alone, and of windows and ticks; a phase for each satellite."""
        inside, ticks = self.met(amplitude, period, factor)
        satellites = np.array([axis[0] for axis in self.axes])
        totals = []
        for verdicts in ((inside,), (inside, ticks)):
            total = 0.0
            for satellite in ("front", "back"):
                met = sum(verdict[satellites == satellite].sum(axis=0) for verdict in verdicts)
                every = len(verdicts)*np.count_nonzero(satellites == satellite)
                total += np.log(np.mean((1 - MISS)**met*MISS**(every - met)))
            totals.append(total)
        return totals

    def amplitudes_asked(self, period):
        """The amplitudes with which a curve, moved up or down at will, spans what its axis asks, at any one phase.

        On automatic ticks a curve is at most as long as its window and longer than all intervals but two."""
        fine = np.arange(0, 0.0201, 0.0001)
        for satellite, quantity, axis, low, high, step in self.axes:
            air, rest = self.curves[satellite, quantity, axis]
            wave = fine[:, None, None]/self.scale*np.sin(2*np.pi*self.time/period + PHASES[:, None])
            extent = np.ptp(air*(1 + wave) + rest, axis=2)
            met = np.any((extent <= (1 + 2*TOLERANCE)*(high - low)) & (extent > high - low - 2*step), axis=1)
            yield f"{satellite} {quantity} {axis}", fine[met]


def print_map(title, values, form="{:7.1f}"):
    print(f"\n{title}\nperiod, s " + "".join(f"{a:8.4f}" for a in AMPLITUDES[::2]))
    for period, row in zip(PERIODS, values):
        print(f"{period:9.1f} " + "".join(" " + form.format(x) for x in row[::2]))


def best(values):
    j, k = np.unravel_index(np.nanargmax(values), values.shape)
    return f"{values[j, k]:.1f} at amplitude {AMPLITUDES[k]:.4f}, period {PERIODS[j]:g} s"


def print_setting(theory, published, amplitude, period, generator, reports=20000):
    """What one setting leaves of the tables."""
    rms = theory.rms(amplitude, period)
    ratio = published/rms[:, None]
    within = inside(published, rms)
    print(f"\nAmplitude {amplitude:g}, period {period:g} s: {within.sum()} of {within.size} inside {LOWEST} to {HIGHEST}")
    for i, a, axis in np.argwhere(~within):
        print(f"  outside: {CASES[i]} {ALGORITHMS[a]} {'xyz'[axis]}: published {published[i, a, axis]:g}, "
              f"theory {rms[i, axis]:.4g} mm, ratio {ratio[i, a, axis]:.3f}")
    drawn = theory.draw(amplitude, period, reports, generator)
    drawn_ratio = drawn/rms[:, None]
    counts = np.sum((drawn_ratio >= LOWEST) & (drawn_ratio <= HIGHEST), axis=(1, 2, 3))
    print("  of 100 such reports: " + ", ".join(f"{100*np.mean(counts >= n):.1f} with {n} or more" for n in range(64, 73)) +
          f"; median {np.median(counts):.0f}")
    for what, over in (("", slice(None)), ("front ", slice(0, 3)), ("back ", slice(3, 6))):
        pooled = np.sqrt(np.mean(ratio[over]**2, axis=(0, 1)))
        chance = np.std(np.sqrt(np.mean(drawn_ratio[:, over]**2, axis=(1, 2))), axis=0)
        above = np.sum(ratio[over] > 1, axis=(0, 1))
        print(f"  {what}published/theory, x y z: " +
              ", ".join(f"{p:.3f} ({(p - 1)/c:+.1f} sigma)" for p, c in zip(pooled, chance)) +
              f"; above theory {above} of {ratio[over][..., 0].size}")
    mean_square, theirs = np.sqrt(np.mean(published**2, axis=1)), np.sqrt(np.mean(drawn**2, axis=2))
    print("  case: RMS of the four published x y z/theory (sigma), y/x and z/x published, theory (sigma of their ratio)")
    for i, case in enumerate(CASES):
        text = f"  {case:8}"
        for axis in range(3):
            asked, chance = mean_square[i, axis]/rms[i, axis], np.std(theirs[:, i, axis]/rms[i, axis])
            text += f" {asked:.3f} ({(asked - 1)/chance:+.1f})"
        for axis in (1, 2):
            asked, given = mean_square[i, axis]/mean_square[i, 0], rms[i, axis]/rms[i, 0]
            spread = np.std(np.log(theirs[:, i, axis]/theirs[:, i, 0]))
            text += f"; {asked:.4f}, {given:.4f} ({np.log(asked/given)/spread:+.1f})"
        print(text)
    found = tables_log_likelihood(theory, published, amplitude, period)
    chance = [tables_log_likelihood(theory, report, amplitude, period) + 2*np.sum(np.log(report)) for report in drawn[:100]]
    shift = 2*np.sum(np.log(published))           # of the density of log q, which has no unit
    print(f"  log likelihood of the tables {found:.2f}; as density of log q {found + shift:.2f}, of 100 drawn reports "
          f"{np.mean(chance):.1f} +- {np.std(chance):.1f}, {np.mean(np.array(chance) < found + shift):.2f} of them less")


def check_theory(theory, program, amplitude, period, runs):
    """Second moments of Monte Carlo runs beside theory's."""
    names = [program.case_file(case, f"{case}-check.nml", density_wave_amplitude=amplitude, density_wave_period=period)
             for case in CASES]
    errors = program.offsets(names, runs) - theory.truth[:, None]
    means = theory.means(amplitude, period)
    print(f"\nMonte Carlo of {runs} runs/theory: RMS x y z (one sigma {1/np.sqrt(2*runs):.3f}), correlations xy, xz, yz of both")
    for i, case in enumerate(CASES):
        moments = errors[i].T @ errors[i]/runs
        asked = theory.covariance[i] + means[i].T @ means[i]/len(PHASES)
        found, given = (np.sqrt(np.diag(m)) for m in (moments, asked))
        print(f"  {case:8} " + " ".join(f"{x:.3f}" for x in found/given) + "; " + ", ".join(
            f"{moments[j, k]/found[j]/found[k]:+.3f} {asked[j, k]/given[j]/given[k]:+.3f}" for j, k in ((0, 1), (0, 2), (1, 2))))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=ROOT/"build/bin/gracecg")
    parser.add_argument("--amplitude", type=float, default=0.0072, help="of the setting that is looked at closely")
    parser.add_argument("--period", type=float, default=19.9, help="s")
    parser.add_argument("--check", type=int, default=0, metavar="RUNS", help="of a Monte Carlo to compare theory with")
    parser.add_argument("--no-maps", action="store_true", help="the one setting and the settings side by side alone")
    parser.add_argument("--printed", action="store_true", help="theory of the cards as printed: nothing fitted to figures but plates")
    arguments = parser.parse_args()
    published = published_values()
    scatter = np.std(np.log(published), axis=1, ddof=1)
    print(f"Scatter of the four algorithms' logarithms, RMS of 18: {np.sqrt(np.mean(scatter**2)):.3f}; of four sets of {RUNS} "
          f"independent runs {1/np.sqrt(2*RUNS):.3f}; of the same runs 0.00001")
    with tempfile.TemporaryDirectory() as folder:
        program = Program(arguments.program, pathlib.Path(folder), "-printed"*arguments.printed)
        theory, windows = Theory(program), Windows(program)
        whole = np.ones((len(CASES), len(ALGORITHMS)), bool)
        whole[0, 3] = False                         # where the misprint is
        if arguments.check:
            check_theory(theory, program, arguments.amplitude, arguments.period, arguments.check)
        if not arguments.no_maps:
            grid = [[(a, p) for a in AMPLITUDES] for p in PERIODS]
            over = lambda function: np.array([[function(*place) for place in row] for row in grid])
            less = lambda values: values - values[0, 0]
            tables = less(over(lambda a, p: tables_log_likelihood(theory, published, a, p)))
            unmended = less(over(lambda a, p: tables_log_likelihood(theory, published, a, p, whole)))
            alone = less(over(lambda a, p: independent_log_likelihood(theory, published, a, p)))
            figures = less(over(windows.log_likelihood))
            print_map("Log likelihood of the tables, 0 without a wave", tables)
            print_map("Entries inside, of 72", over(lambda a, p: inside(published, theory.rms(a, p)).sum()), "{:7.0f}")
            print_map("Log likelihood of windows and ticks, 0 without a wave", figures[..., 1])
            print("\ngreatest log likelihood, 0 without a wave")
            for what, values in (("tables", tables), ("tables without front-1 ascrest (misprint)", unmended),
                                 ("tables, axes taken as independent", alone), ("windows", figures[..., 0]),
                                 ("windows and ticks", figures[..., 1]), ("tables and windows", tables + figures[..., 0]),
                                 ("tables, windows and ticks", tables + figures[..., 1])):
                print(f"  {what}: {best(values)}")
            print("\namplitudes that an axis allows a curve of free mean, by period, s")
            asked = [dict(windows.amplitudes_asked(p)) for p in (12, 15.5, 19.9)]
            for name in asked[0]:
                print(f"  {name:28}" + "".join(f"{each[name].min():10.4f} to {each[name].max():.4f}" if each[name].size else
                                               "              none" for each in asked))
            print("\nwindows and ticks, by factor of the density (amplitude, period of the setting): log likelihood")
            for factor in np.arange(0.97, 1.0301, 0.01):
                print(f"  {factor:.2f}: {windows.log_likelihood(arguments.amplitude, arguments.period, factor)[0]:.1f}, "
                      f"{windows.log_likelihood(arguments.amplitude, arguments.period, factor)[1]:.1f}")
        print("\nsettings side by side, log likelihoods: tables, the same without front-1 ascrest, with independent axes; windows, "
              "windows and ticks; sum of tables, windows and ticks;\nentries of 72; windows and ticks of 18 (most of all phases)")
        for a, p in dict.fromkeys(SETTINGS + ((arguments.amplitude, arguments.period),)):
            asked = tables_log_likelihood(theory, published, a, p)
            figures, met = windows.log_likelihood(a, p), windows.met(a, p)
            print(f"  {a:g}, {p:g} s: {asked:.1f}, {tables_log_likelihood(theory, published, a, p, whole):.1f}, "
                  f"{independent_log_likelihood(theory, published, a, p):.1f}; {figures[0]:.1f}, {figures[1]:.1f}; "
                  f"{asked + figures[1]:.1f}; {inside(published, theory.rms(a, p)).sum()}; "
                  f"{met[0].sum(axis=0).max()}, {met[1].sum(axis=0).max()}")
        generator = np.random.default_rng(1)
        print_setting(theory, published, arguments.amplitude, arguments.period, generator)


if __name__ == "__main__":
    main()
