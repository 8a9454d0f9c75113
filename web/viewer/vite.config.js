// One page that carries everything: it opens from disk, loads nothing and is what `antumbra view` serves.
import { defineConfig } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

/** glTF has a decoder of its own, which we carry; DRACOLoader also names the general ones, 1.4 MB that nobody asks for. */
const withoutGeneralDraco = {
  name: 'without-general-draco',
  enforce: 'pre',
  transform: (code, id) => (id.endsWith('/DRACOLoader.js')
    ? code.replace(/new URL\( '\.\.\/libs\/draco\/draco_[^)]*\)\.toString\(\)/g, "''") : null),
};

export default defineConfig({
  base: './',
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
