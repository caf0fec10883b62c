// Draws blocks marked `mermaid`; without the library they stay readable text.
(() => {
    if (typeof mermaid === "undefined") return;
    const blocks = document.querySelectorAll("code.language-mermaid");
    for (const code of blocks) {
        const picture = document.createElement("pre");
        picture.className = "mermaid";
        picture.textContent = code.textContent;
        code.parentElement.replaceWith(picture);
    }
    const dark = ["navy", "coal", "ayu"];
    const isDark = dark.some((name) => document.documentElement.classList.contains(name));
    mermaid.initialize({ startOnLoad: false, theme: isDark ? "dark" : "default" });
    mermaid.run();
})();
