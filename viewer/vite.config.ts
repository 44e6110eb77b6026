import { defineConfig } from "vite";

// Three files with fixed names, relative to the folder of the token: they are built into the command.
export default defineConfig({
  base: "./",
  build: {
    target: "es2022",
    emptyOutDir: false,
    modulePreload: false,
    chunkSizeWarningLimit: 1000,
    rollupOptions: {
      output: { entryFileNames: "app.js", assetFileNames: "app[extname]", inlineDynamicImports: true },
    },
  },
});
