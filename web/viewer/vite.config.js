// One page that carries everything: it opens from disk, loads nothing and is what `antumbra view` serves.
import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

const packageFolder = fileURLToPath(new URL('../antumbra', import.meta.url));

/** glTF has a decoder of its own, which we carry; DRACOLoader also names the general ones, 1.4 MB that nobody asks for. */
const withoutGeneralDraco = {
  name: 'without-general-draco',
  enforce: 'pre',
  transform: (code, id) => (id.endsWith('/DRACOLoader.js')
    ? code.replace(/new URL\( '\.\.\/libs\/draco\/draco_[^)]*\)\.toString\(\)/g, "''") : null),
};

export default defineConfig({
  base: './',
  // The package as it lies beside; its WebAssembly is made by the build of the C++ part.
  resolve: { alias: [
    { find: /^antumbra$/, replacement: `${packageFolder}/src/index.js` },
    { find: /^antumbra\/cull$/, replacement: `${packageFolder}/src/cull.js` },
    { find: /^antumbra\/three$/, replacement: `${packageFolder}/src/three.js` },
    { find: 'node:fs/promises', replacement: fileURLToPath(new URL('src/no_files.ts', import.meta.url)) }], dedupe: ['three'] },
  plugins: [withoutGeneralDraco, viteSingleFile({ removeViteModuleLoader: true })],
  optimizeDeps: { exclude: ['three'] },
  build: {
    target: 'es2022',
    outDir: process.env.ANTUMBRA_VIEWER_OUT ?? 'dist',
    emptyOutDir: true,
    assetsInlineLimit: () => true,
    reportCompressedSize: false,
    chunkSizeWarningLimit: 4000,
  },
});
