// A page that was opened as a file may not read others, so search could not show the text around what it found.
// build.py puts the text of each page here; served by a web server, pages are read as usual.
const pages = {};

if (window.location.protocol === "file:") {
  const fromNetwork = window.fetch;
  window.fetch = (address) => {
    const name = decodeURIComponent(String(address).split(/[?#]/)[0]).replace(/^(\.\/)+/, "");
    if (!(name in pages)) return fromNetwork(address);
    const main = document.createElement("div");
    main.setAttribute("role", "main");
    main.textContent = pages[name];
    return Promise.resolve(new Response(main.outerHTML));
  };
}
