// The host of the WebAssembly module.

/** Returns the imports of WASI's C library (a clock and no output) and `own` functions. `memory` returns the module's memory. */
export function wasiHost(memory, own) {
  const view = () => new DataView(memory().buffer);
  const known = {
    clock_time_get(id, precision, at) {
      view().setBigUint64(at, BigInt(Math.round(performance.now() * 1e6)), true);
      return 0;
    },
    fd_write(file, list, count, written) {
      let size = 0;
      for (let i = 0; i < count; ++i) size += view().getUint32(list + 8 * i + 4, true);
      view().setUint32(written, size, true);
      return 0;
    },
    ...own,
  };
  const badFile = 8;
  return new Proxy(known, { get: (all, name) => all[name] ?? (() => badFile) });
}

/** Returns the imports of a module, grouped by import module. */
export function importsOf(module, host) {
  const imports = {};
  for (const { module: group, name } of WebAssembly.Module.imports(module)) (imports[group] ??= {})[name] = host[name];
  return imports;
}
