"""Reads the tables of `drape export` with pandas, polars and DuckDB and compares every entry.

read_tables.py CSV PARQUET: two folders with the same tables. What counts is what Python's own module
`csv` reads from the first folder.
"""

import csv
import pathlib
import sys
import warnings

import duckdb
import pandas
import polars

TYPES = {"particles": int, "stiffness_over_mass": float, "step_s": float, "value": float,
         "cost_s": float, "quick": lambda text: text == "true"}
COLUMNS = ["study", "cell", "scene", "particles", "stiffness_over_mass", "method", "settings",
           "step_s", "metric", "value", "unit", "verdict", "cost_s", "cost_of", "machine", "commit",
           "quick"]


def expected(file):
    """The columns of a table; None for an empty entry."""
    with open(file, newline="", encoding="utf-8") as text:
        lines = csv.reader(text)
        header = next(lines)
        kinds = [TYPES.get(name, str) for name in header]
        columns = [[] for _ in header]
        # Most entries are there many times: each is made once.
        known = [{"": None} for _ in header]
        for row in lines:
            assert len(row) == len(header), (file, row)
            for entry, kind, entries, column in zip(row, kinds, known, columns):
                if entry not in entries:
                    entries[entry] = kind(entry)
                column.append(entries[entry])
    return dict(zip(header, columns))


# Versions before 3.1 read all digits only when they are told so; later ones always do.
warnings.filterwarnings("ignore", message=".*float_precision.*")


def by_pandas(file):
    if file.suffix == ".csv":
        words = {name: str for name in COLUMNS + ["name", "kind", "meaning", "table"]
                 if name not in TYPES}
        frame = pandas.read_csv(file, dtype=words, float_precision="round_trip",
                                keep_default_na=False,
                                na_values={name: [""] for name in [*TYPES, *words]})
    else:
        frame = pandas.read_parquet(file)
    entries = lambda column: [None if is_missing else entry for entry, is_missing
                              in zip(column.tolist(), column.isna().tolist())]
    return {name: entries(frame[name]) for name in frame.columns}


def by_polars(file):
    read = polars.read_parquet
    if file.suffix == ".csv":
        typed = {"cell": polars.String, "scene": polars.String, "settings": polars.String,
                 "value": polars.Float64, "step_s": polars.Float64, "unit": polars.String,
                 "stiffness_over_mass": polars.Float64, "cost_s": polars.Float64}
        return polars.read_csv(file, schema_overrides=typed, infer_schema_length=None).to_dict(
            as_series=False)
    return read(file).to_dict(as_series=False)


def by_duckdb(file):
    source = f"'{file}'"
    if file.suffix == ".csv":
        source = (f"read_csv('{file}', header=true, sample_size=-1, delim=',', quote='\"', "
                  "escape='\"')")
    table = duckdb.sql(f"select * from {source}")
    rows = table.fetchall()
    return {name: [row[k] for row in rows] for k, name in enumerate(table.columns)}


def same(a, b):
    if a is None or b is None:
        return a is b
    if isinstance(a, float) or isinstance(b, float):
        return float(a) == float(b)
    return a == b or str(a) == str(b)


def summary(table):
    """Which entries each column has, and each pair of a cost and its key."""
    entries = {name: set(column) for name, column in table.items()}
    return entries, set(zip(table["cost_s"], table["cost_of"]))


def check(dictionary, tables):
    """What the dictionary and the summaries of the tables say of themselves."""
    assert list(dictionary) == ["name", "kind", "unit", "meaning", "table"], list(dictionary)
    assert all(dictionary["meaning"]), "a line of the dictionary without a meaning"
    lines = list(zip(*(dictionary[name] for name in ["table", "name", "unit"])))
    assert len(set(lines)) == len(lines), "a metric of a table twice in the dictionary"
    told = {line for line, kind in zip(lines, dictionary["kind"]) if kind == "metric"}
    columns = {name for name, kind in zip(dictionary["name"], dictionary["kind"])
               if kind == "column"}
    assert columns == set(COLUMNS), columns
    for name, (table, costs) in tables.items():
        assert list(table) == COLUMNS, (name, list(table))
        study = name.removeprefix("timings-").removeprefix("engines-")
        assert table["study"] == {study}, name
        assert all(machine.endswith((" thread", " threads")) for machine in table["machine"]), name
        for cost, of in costs:
            assert (cost is None) == (of is None) and (cost is None or cost >= 0), (name, cost, of)
        metrics = {".".join("#" if part.isdigit() else part for part in metric.split("."))
                   for metric in table["metric"]}
        assert metrics == {metric for of, metric, _ in told if of == name}, name
        if name.startswith("timings-"):
            assert not any(table["quick"]), name
            # Its times are those of whole comparisons, not of runs.
            assert any(table["cost_of"]) or study == "regret", name
    kinds = [name.partition("-")[0] for name in tables]
    assert kinds.count("timings") >= 3 and kinds.count("engines") >= 2, sorted(tables)


def main():
    folders = [pathlib.Path(folder) for folder in sys.argv[1:3]]
    entries = 0
    tables = {}
    for file in sorted(folders[0].glob("*.csv")):
        wanted = expected(file)
        if file.stem == "dictionary":
            dictionary = wanted
        else:
            tables[file.stem] = summary(wanted)
        for folder in folders:
            read = folder / (file.stem + ("." + folder.name))
            for reader in by_pandas, by_polars, by_duckdb:
                found = reader(read)
                assert list(found) == list(wanted), (read, reader.__name__, list(found))
                for name, column in wanted.items():
                    entries += len(column)
                    if found[name] == column:
                        continue
                    # They differ, or are the same in another type.
                    assert len(found[name]) == len(column), (read, reader.__name__, name)
                    for row, (a, b) in enumerate(zip(column, found[name])):
                        if not same(a, b):
                            sys.exit(f"{read} by {reader.__name__}: row {row}, {name}: "
                                     f"{b!r} in place of {a!r}")
    check(dictionary, tables)
    print(entries)


main()
