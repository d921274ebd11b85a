// A method with its settings as one text, `id:preset,key=value`, as commands name it.

import type { MethodChoice, SettingChoice } from "./messages";

interface Parts {
  id: string;
  preset: string | undefined;
  pairs: [string, string][];
}

function parts(text: string): Parts {
  const at = text.indexOf(":");
  const id = (at < 0 ? text : text.slice(0, at)).trim();
  const words = (at < 0 ? "" : text.slice(at + 1))
    .split(",")
    .map((word) => word.trim())
    .filter((word) => word !== "");
  const isPreset = words[0] !== undefined && !words[0].includes("=");
  const preset = isPreset ? words.shift() : undefined;
  const pairs = words.map((word): [string, string] => {
    const equals = word.indexOf("=");
    return equals < 0 ? [word, ""] : [word.slice(0, equals).trim(), word.slice(equals + 1).trim()];
  });
  return { id, preset, pairs };
}

/** The method that a text names. */
export function methodOf(methods: MethodChoice[], text: string): MethodChoice | undefined {
  const { id } = parts(text);
  return methods.find((method) => method.id === id);
}

/** The value of a setting that the text does not set: from the preset, or else the default. */
function usual(method: MethodChoice, preset: string | undefined, setting: SettingChoice): string {
  const known = method.presets.find(({ name }) => name === preset);
  return known?.settings.find(([key]) => key === setting.key)?.[1] ?? setting.default;
}

/** The value of a setting. */
export function valueOf(method: MethodChoice, text: string, setting: SettingChoice): string {
  const { preset, pairs } = parts(text);
  return pairs.find(([key]) => key === setting.key)?.[1] ?? usual(method, preset, setting);
}

/** Whether two texts are the same value. */
export function isSame(a: string, b: string): boolean {
  return a === b || (a.trim() !== "" && b.trim() !== "" && Number(a) === Number(b));
}

/** The text with another value of a setting; the same text where the method has none of that key. */
export function withSetting(
  methods: MethodChoice[],
  text: string,
  key: string,
  value: string,
): string {
  const method = methodOf(methods, text);
  const setting = method?.settings.find((known) => known.key === key);
  if (method === undefined || setting === undefined) return text;
  const { id, preset, pairs } = parts(text);
  const rest = pairs.filter(([known]) => known !== key);
  const isUsual = isSame(value, usual(method, preset, setting));
  if (!isUsual) rest.push([key, value]);
  const words = [
    ...(preset === undefined ? [] : [preset]),
    ...rest.map(([known, given]) => `${known}=${given}`),
  ];
  return words.length === 0 ? id : `${id}:${words.join(",")}`;
}
