# SPDX-License-Identifier: Apache-2.0
"""Measured rows as Markdown."""



def label(row, table):
    """What distinguishes a row from the others of its table, in words."""
    keys = []
    for key, values in table["vary"].items():
        keys += [k for value in values if isinstance(value, dict) for k in value] or [key]
    words = []
    for key in dict.fromkeys(keys):
        value = row[key]
        if key == "flags":
            words.append(" ".join(value))
        elif key == "pixels":
            words.append(f"{value}^2")
        elif key == "magnification":
            words.append(f"{value} pixel{'s' if value > 1 else ''} per voxel")
        elif key == "threads":
            words.append(f"{value} thread{'s' if value > 1 else ''}")
        else:
            words.append(str(value))
    return ", ".join(word for word in words if word)


def stage_ms(profile, *names):
    return sum(profile["stages_ms"].get(name, 0.0) for name in names)


def fma_share(result):
    """The multiply-adds that the reconstructed values and gradients need, over what the machine could do in the stages' time.

    A value is one multiply-add per kernel that reaches the sample, a gradient three more; the sums of weights, the loads and the
    addresses are the overhead that keeps the share below one. Stage times are summed over threads, so the peak is one thread's.
    """
    profile = result["ovoid"]
    needed = profile["multiply_adds"]["done"]
    seconds = stage_ms(profile, "reconstruct", "gradient") / 1e3
    return needed / seconds / profile["multiply_adds"]["peak"] if seconds else None


def ns_per_shaded(result):
    shaded = result["ovoid"]["samples"]["shaded"]
    return stage_ms(result["ovoid"], "shade", "composite") * 1e6 / shaded if shaded else None


def number(value, digits=1, suffix=""):
    return "-" if value is None else f"{value:.{digits}f}{suffix}"


def grid(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|---" + "|---:" * (len(header) - 1) + "|"]
    return lines + ["| " + " | ".join(row) + " |" for row in rows]


def time_table(results, table):
    """Milliseconds per frame: median (least to greatest), and how many times faster than each peer."""
    peers = results[0]["row"]["peers"]
    header = ["scene", "ovoid ms", "least to greatest"]
    for peer in peers:
        header += [f"VTK {peer} ms", f"{peer} / ovoid", "PSNR dB"]
    header += ["peak memory MiB"]
    rows = []
    for result in results:
        time = result["ovoid"]["frame_ms"]
        row = [label({**result["row"], "pixels": result["pixels"]}, table), number(time["median"]),
               f"{time['min']:.1f} to {time['max']:.1f}"]
        for peer in peers:
            theirs = result[peer]["frame_ms"]["median"]
            row += [number(theirs), number(theirs / time["median"], 2), number(result["psnr"][peer])]
        rows.append(row + [number(result["ovoid"]["peak_memory_bytes"] / 2**20, 0)])
    return grid(header, rows)


def stage_table(results, table):
    """One frame with stage timers on: milliseconds summed over threads, and what was done in them."""
    names = list(dict.fromkeys(name for result in results for name in result["ovoid"]["stages_ms"]))
    header = ["scene", *names, "Msamples", "shaded", "ns per shaded", "FMA share", "blocks drawn", "empty", "irrelevant", "opaque"]
    rows = []
    for result in results:
        profile = result["ovoid"]
        blocks = profile["blocks"]
        share = fma_share(result)
        rows.append([label({**result["row"], "pixels": result["pixels"]}, table),
                     *(number(profile["stages_ms"].get(name)) for name in names),
                     number(profile["samples"]["reconstructed"] / 1e6, 2), number(profile["samples"]["shaded"] / 1e6, 2),
                     number(ns_per_shaded(result)), number(share, 2), f"{blocks['drawn']} of {blocks['total']}",
                     *(str(blocks["skipped"][why]) for why in ("empty", "irrelevant", "opaque"))])
    return grid(header, rows)


def to_markdown(record, config):
    machine = record["machine"]
    drawn = [result["ovoid"] for results in record["tables"].values() for result in results]
    peak = max((profile["multiply_adds"]["peak"] for profile in drawn), default=0)
    targets = {profile["simd_target"] for profile in drawn}
    lines = [f"Commit {machine['commit']}, {machine['date']}; {machine['cpu']}, {machine['hardware_threads']} hardware threads, "
             f"SIMD target {', '.join(sorted(targets))}; {machine['compiler']}.",
             f"Peak of one thread: {peak / 1e9:.1f} G multiply-adds per second. Command: `{machine['command']}`."]
    for name, results in record["tables"].items():
        table = config["tables"][name]
        if results:
            lines += ["", f"## {table['title']}", "", *time_table(results, table), "", "Stages, in ms summed over threads:", "",
                      *stage_table(results, table)]
    return "\n".join(lines)
