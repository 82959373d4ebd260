import { defineConfig } from 'vite';

/** Where a service runs while the viewer is worked on: `npm run dev`. */
const service = 'http://127.0.0.1:8080';

export default defineConfig({
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
