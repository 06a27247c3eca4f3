# Prints the tables of bench/run.sh from its rows and the JSON output of Google Benchmark (one key per line).

function text(line) { # value of a key
    sub(/^[^:]*: */, "", line)
    sub(/,$/, "", line)
    gsub(/^"|"$/, "", line)
    return line
}
function sort(values, n,    i, j, x) {
    for (i = 2; i <= n; ++i) {
        x = values[i]
        for (j = i - 1; j >= 1 && values[j] > x; --j) values[j + 1] = values[j]
        values[j + 1] = x
    }
}
# Returns a quantile of benchmark `key` (group and name) of processor time or, with threads, of elapsed time.
function quantile(kind, key, share,    values, i, at) {
    for (i = 1; i <= count[key]; ++i) values[i] = seconds[kind, key, i]
    sort(values, count[key])
    at = 1 + share * (count[key] - 1)
    i = int(at)
    return i == count[key] ? values[i] : values[i] + (at - i) * (values[i + 1] - values[i])
}
function shown(s) { return s >= 0.1 ? sprintf("%.2f s", s) : s >= 1e-3 ? sprintf("%.3g ms", 1e3 * s) : sprintf("%.3g us", 1e6 * s) }
function spread(kind, key,    median) {
    median = quantile(kind, key, 0.5)
    return sprintf("-%.0f +%.0f %%", 100 * (1 - quantile(kind, key, 0.25) / median), 100 * (quantile(kind, key, 0.75) / median - 1))
}
function missing(key) { return key in failed ? "failed: " failed[key] : "missing" }
# The fastest of several benchmarks, separated by &; "" if none ran.
function best(group, names,    parts, of, i, key, found) {
    parts = split(names, of, / *& */)
    for (i = 1; i <= parts; ++i) {
        key = group SUBSEP of[i]
        if (count[key] > 0 && (found == "" || quantile("cpu", key, 0.5) < quantile("cpu", found, 0.5))) found = key
    }
    return found
}
function csv_line(what, threads, side, key, kind) {
    if (csv != "" && key != "" && count[key] > 0)
        printf "\"%s\",%d,\"%s\",%.6g,%.6g,%.6g,%d\n", what, threads, side, quantile(kind, key, 0.5), quantile(kind, key, 0.25),
               quantile(kind, key, 0.75), count[key] > csv
}
function line(format, a, b, c, d, e, f, g, h) { printf format "\n", a, b, c, d, e, f, g, h }
function dashes(n,    s) { while (n-- > 0) s = s "-"; return s }

BEGIN {
    wide = "| %-60s | %9s | %-10s | %-36s | %-10s | %6s | %-23s | %5s |"
    narrow = "| %-50s | %9s | %9s %6s | %9s %6s |"
    if (csv != "") print "what,threads,side,median_s,first_quartile_s,third_quartile_s,repetitions" > csv
}
FNR == 1 { ++file; group = FILENAME; sub(/.*\//, "", group); sub(/\..*/, "", group) }
file == 1 { row[++rows] = $0; next }
/^ *"run_name":/ { key = group SUBSEP text($0) }
/^ *"run_type":/ { measured = text($0) == "iteration" }
/^ *"error_message":/ { failed[key] = text($0); measured = 0 }
/^ *"real_time":/ { real = text($0) }
/^ *"cpu_time":/ { cpu = text($0) }
/^ *"time_unit":/ && measured {
    unit = text($0) == "ns" ? 1e-9 : text($0) == "us" ? 1e-6 : text($0) == "ms" ? 1e-3 : 1
    ++count[key]
    seconds["real", key, count[key]] = real * unit
    seconds["cpu", key, count[key]] = cpu * unit
    measured = 0
}

END {
    for (r = 1; r <= rows; ++r) {
        group = row[r]
        sub(/ .*/, "", group)
        sub(/^[0-9]+ /, "", row[r])
        columns = split(row[r], part, / *; */)
        if (columns > 2) first_table(group, part)
        else if (part[2] ~ /%/) levels_table(group, part)
        else second_table(group, part)
    }
}
function first_table(group, part,    ours, peer, limit, a, b) {
    if (!one_thread++) {
        ++tables
        print "One thread: medians of processor time with quartiles. ratio: peer/ours; share: limit/ours, the part of the time that"
        print "no program can avoid."
        line(wide, "", "ours", "", "peer", "", "ratio", "limit", "share")
        line("|%s|%s|%s|%s|%s|%s|%s|%s|", dashes(62), dashes(11), dashes(12), dashes(38), dashes(12), dashes(8), dashes(25), dashes(7))
    }
    ours = group SUBSEP part[2]
    if (!count[ours]) { line(wide, part[1], missing(ours), "", "", "", "", "", ""); return }
    a = quantile("cpu", ours, 0.5)
    peer = best(group, part[4])
    limit = group SUBSEP part[6]
    if (peer != "") b = quantile("cpu", peer, 0.5)
    line(wide, part[1], shown(a), spread("cpu", ours), part[3] ": " (peer != "" ? shown(b) : missing(group SUBSEP part[4])),
         peer != "" ? spread("cpu", peer) : "", peer != "" ? sprintf("%.2f", b / a) : "",
         part[5] ": " (count[limit] ? shown(quantile("cpu", limit, 0.5)) : missing(limit)),
         count[limit] ? sprintf("%.0f %%", 100 * quantile("cpu", limit, 0.5) / a) : "")
    csv_line(part[1], 1, "ours", ours, "cpu")
    csv_line(part[1], 1, part[3], peer, "cpu")
    csv_line(part[1], 1, part[5], limit, "cpu")
}
function second_table(group, part,    n, name, key, time, cell) {
    sub(/^threads: /, "", part[1])
    if (!threads++) {
        if (tables++ > 0) print ""
        print "Threads: medians of elapsed time, and speedup over one thread."
        if (quiet == "no") print "WARNING: the machine was under load at the start; rows are not comparable."
        while ((getline warning < warnings) > 0) print warning
        if (cores < 4) print "WARNING: only " cores " processors; more threads share them."
        line(narrow, "", "1 thread", "2", "", "4", "")
        line("|%s|%s|%s|%s|", dashes(52), dashes(11), dashes(18), dashes(18))
    }
    for (n = 1; n <= 4; n *= 2) {
        name = part[2]
        sub(/@/, n, name)
        key = group SUBSEP name
        time[n] = count[key] ? quantile("real", key, 0.5) : 0
        cell[n] = time[n] > 0 ? shown(time[n]) : missing(key)
        csv_line(part[1], n, "ours", key, "real")
    }
    line(narrow, part[1], cell[1], cell[2], time[2] > 0 ? sprintf("%.2fx", time[1] / time[2]) : "", cell[4],
         time[4] > 0 ? sprintf("%.2fx", time[1] / time[4]) : "")
}
# Clones compiled at -O2 and -O3.
function level_cells(group, names, object, what,    fast, slow) {
    fast = slow = names
    sub(/%/, object "-O3", fast)
    sub(/%/, object "-O2", slow)
    fast = group SUBSEP fast
    slow = group SUBSEP slow
    csv_line(what ", " object " -O3", 1, "ours", fast, "cpu")
    csv_line(what ", " object " -O2", 1, "ours", slow, "cpu")
    if (!count[fast] || !count[slow]) return sprintf(" %9s | %9s %6s |", missing(fast), missing(slow), "")
    return sprintf(" %9s | %9s %6.2f |", shown(quantile("cpu", fast, 0.5)), shown(quantile("cpu", slow, 0.5)),
                   quantile("cpu", slow, 0.5) / quantile("cpu", fast, 0.5))
}
function levels_table(group, part) {
    sub(/^level: /, "", part[1])
    if (!levels++) {
        if (tables++ > 0) print ""
        print "Optimisation levels, portable flags: medians of processor time; after -O2 the ratio -O2/-O3."
        line("| %-50s | %9s | %16s | %9s | %16s |", "", "g++ -O3", "-O2", "clang -O3", "-O2")
        line("|%s|%s|%s|%s|%s|", dashes(52), dashes(11), dashes(18), dashes(11), dashes(18))
    }
    printf "| %-50s |%s%s\n", part[1], level_cells(group, part[2], "gxx", part[1]), level_cells(group, part[2], "clang", part[1])
}
