// node wasi.js PROGRAM.wasm: runs a program compiled for WebAssembly's system interface.
"use strict";
process.removeAllListeners("warning"); // of node, that this interface is young
const { WASI } = require("wasi");
const wasi = new WASI({ version: "preview1" });
const bytes = require("fs").readFileSync(process.argv[2]);
WebAssembly.instantiate(bytes, { wasi_snapshot_preview1: wasi.wasiImport }).then(({ instance }) => {
  process.exitCode = wasi.start(instance);
});
