/** What lies on the ground rather than stands on it; the service's own view of a city judges the same way. */

/** CityJSON types whose box is as high as the ground rises in it, and says little of how they look. */
const COVERS = new Set(['LandUse', 'PlantCover', 'Road', 'Railway', 'TransportSquare', 'WaterBody', 'Waterway', 'TINRelief']);

/** What has no class of its own counts as lying where it is so many times wider than high. */
const BROAD = 3;

const plain = (name: string) => name.replace(/^\++/, '');

/** Whether all of a class lies on the ground. */
export const isCover = (name: string): boolean => COVERS.has(plain(name));

/** Tells of a class by its number, and a box so wide and high, m. */
export function covers(classes: readonly string[]): (kind: number, wide: number, high: number) => boolean {
  const names = classes.map(plain);
  return (kind, wide, high) => {
    const name = names[kind] ?? '';
    return COVERS.has(name) || (name === 'GenericCityObject' && wide > BROAD * high);
  };
}
