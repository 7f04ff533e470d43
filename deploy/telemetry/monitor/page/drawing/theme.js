// Light or dark: the system's setting until the reader chooses; the choice is stored.
const KEY = "disknav-theme";
const CHOICES = ["system", "light", "dark"];
const WORDS = { system: "Theme: system", light: "Theme: light", dark: "Theme: dark" };

export function followTheme(button, changed) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  let choice = localStorage.getItem(KEY) ?? "system";

  function apply() {
    const dark = choice === "dark" || (choice === "system" && system.matches);
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    button.textContent = WORDS[choice];
    changed();
  }

  button.addEventListener("click", () => {
    choice = CHOICES[(CHOICES.indexOf(choice) + 1) % CHOICES.length];
    localStorage.setItem(KEY, choice);
    apply();
  });
  system.addEventListener("change", apply);
  apply();
}
