import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { defineConfig } from 'vite';

/** Puts a compressed copy beside each part that is worth it: the service sends that where it can. */
const pack = {
  name: 'pack',
  apply: 'build',
  writeBundle({ dir }) {
    const folder = join(dir ?? 'dist', 'assets');
    for (const name of readdirSync(folder).filter((name) => /\.(js|css)$/.test(name))) {
      writeFileSync(join(folder, `${name}.gz`), gzipSync(readFileSync(join(folder, name)), { level: 9 }));
    }
  },
};

/** Where a service runs while the viewer is worked on: `npm run dev`. */
const service = 'http://127.0.0.1:8080';

export default defineConfig({
  plugins: [pack],
  build: {
    target: 'es2022',
    // Fonts stay files of their own: they are wanted later than the page.
    assetsInlineLimit: 0,
    license: { fileName: 'assets/licenses.md' },
    chunkSizeWarningLimit: 700,
  },
  server: {
    proxy: {
      '/collections': { target: service, ws: true },
      '/about': service,
      '/api': service,
    },
  },
});
