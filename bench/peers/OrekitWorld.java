// A day of orbit and magnetic field by Orekit, and messages of CCSDS as Orekit reads them: for bench/orekit_world.py.
//     OrekitWorld fly FOLDER FIELD SECONDS X Y Z VX VY VZ DURATION
//     OrekitWorld read OEM AEM
import java.io.File;
import java.nio.file.Files;
import java.nio.file.Paths;
import java.util.Collections;
import java.util.List;
import java.util.Locale;
import org.hipparchus.geometry.euclidean.threed.Rotation;
import org.hipparchus.geometry.euclidean.threed.Vector3D;
import org.hipparchus.ode.nonstiff.DormandPrince853Integrator;
import org.orekit.bodies.GeodeticPoint;
import org.orekit.bodies.OneAxisEllipsoid;
import org.orekit.data.DataContext;
import org.orekit.data.DataSource;
import org.orekit.data.DirectoryCrawler;
import org.orekit.files.ccsds.ndm.ParserBuilder;
import org.orekit.forces.gravity.HolmesFeatherstoneAttractionModel;
import org.orekit.forces.gravity.potential.GravityFieldFactory;
import org.orekit.forces.gravity.potential.ICGEMFormatReader;
import org.orekit.forces.gravity.potential.NormalizedSphericalHarmonicsProvider;
import org.orekit.frames.Frame;
import org.orekit.frames.FramesFactory;
import org.orekit.models.earth.GeoMagneticField;
import org.orekit.orbits.CartesianOrbit;
import org.orekit.orbits.OrbitType;
import org.orekit.propagation.BoundedPropagator;
import org.orekit.propagation.EphemerisGenerator;
import org.orekit.propagation.SpacecraftState;
import org.orekit.propagation.numerical.NumericalPropagator;
import org.orekit.time.AbsoluteDate;
import org.orekit.time.DateComponents;
import org.orekit.time.OffsetModel;
import org.orekit.time.TimeScalesFactory;
import org.orekit.utils.Constants;
import org.orekit.utils.IERSConventions;
import org.orekit.utils.PVCoordinates;
import org.orekit.utils.TimeStampedAngularCoordinates;
import org.orekit.utils.TimeStampedPVCoordinates;

public class OrekitWorld {
    static final int DEGREE = 20;       // of the geopotential
    static final double MU = 3.986004415e14;    // m^3/s^2: an OEM does not say it, and the parser asks

    static class Field extends GeoMagneticField {
        Field(List<String> lines) {     // degree, order, g, h in nT
            super("IGRF", 2020.0, 13, 13, 1900.0, 2100.0);
            for (String line : lines) {
                final String[] word = line.trim().split(" +");
                final int n = Integer.parseInt(word[0]), m = Integer.parseInt(word[1]);
                setMainFieldCoefficients(n, m, Double.parseDouble(word[2]), Double.parseDouble(word[3]));
                setSecularVariationCoefficients(n, m, 0, 0);
            }
        }
    }

    public static void main(String[] args) throws Exception {
        Locale.setDefault(Locale.ROOT);
        TimeScalesFactory.addUTCTAIOffsetsLoader(
            () -> Collections.singletonList(new OffsetModel(new DateComponents(2017, 1, 1), 37)));
        final AbsoluteDate epoch = new AbsoluteDate(2000, 1, 1, 12, 0, 0.0, TimeScalesFactory.getGPS());
        if (args[0].equals("fly")) {
            fly(args, epoch);
        } else {
            final DataSource oem = new DataSource(new File(args[1])), aem = new DataSource(new File(args[2]));
            for (TimeStampedPVCoordinates pv :
                     new ParserBuilder().withMu(MU).buildOemParser().parseMessage(oem).getSegments().get(0).getCoordinates()) {
                show("orbit", pv.getDate().durationFrom(epoch), pv.getPosition(), pv.getVelocity());
            }
            for (TimeStampedAngularCoordinates a :
                     new ParserBuilder().buildAemParser().parseMessage(aem).getSegments().get(0).getAngularCoordinates()) {
                final Rotation r = a.getRotation();     // inertial x and y in body axes
                show("attitude", a.getDate().durationFrom(epoch), r.applyTo(Vector3D.PLUS_I), r.applyTo(Vector3D.PLUS_J));
            }
        }
    }

    static void show(String what, double time, Vector3D... vectors) {
        final StringBuilder line = new StringBuilder(String.format("%s %.6f", what, time));
        for (Vector3D v : vectors) line.append(String.format(" %.17g %.17g %.17g", v.getX(), v.getY(), v.getZ()));
        System.out.println(line);
    }

    // Gravity alone. The Earth turns by the IERS Conventions of 2010, with UT1 = UTC and no polar motion: no parameters are loaded.
    static void fly(String[] args, AbsoluteDate epoch) throws Exception {
        DataContext.getDefault().getDataProvidersManager().addProvider(new DirectoryCrawler(new File(args[1])));
        GravityFieldFactory.addPotentialCoefficientsReader(new ICGEMFormatReader("peer\\.gfc", true));
        final Field field = new Field(Files.readAllLines(Paths.get(args[2])));
        final double[] x = new double[8];
        for (int i = 0; i < 8; i++) x[i] = Double.parseDouble(args[3 + i]);
        final AbsoluteDate start = epoch.shiftedBy(x[0]);
        final double duration = x[7];
        final Frame inertial = FramesFactory.getGCRF(), fixed = FramesFactory.getITRF(IERSConventions.IERS_2010, true);
        final NormalizedSphericalHarmonicsProvider provider =
            GravityFieldFactory.getConstantNormalizedProvider(DEGREE, DEGREE, start);
        final double[] absolute = {1e-6, 1e-6, 1e-6, 1e-9, 1e-9, 1e-9, 1};
        final NumericalPropagator propagator =
            new NumericalPropagator(new DormandPrince853Integrator(1e-3, 60, absolute, new double[7]));
        propagator.setOrbitType(OrbitType.CARTESIAN);
        propagator.addForceModel(new HolmesFeatherstoneAttractionModel(fixed, provider));
        propagator.setInitialState(new SpacecraftState(new CartesianOrbit(
            new PVCoordinates(new Vector3D(x[1], x[2], x[3]), new Vector3D(x[4], x[5], x[6])), inertial, start, provider.getMu())));
        final EphemerisGenerator generator = propagator.getEphemerisGenerator();
        propagator.propagate(start.shiftedBy(duration));
        final BoundedPropagator orbit = generator.getGeneratedEphemeris();
        final OneAxisEllipsoid earth =
            new OneAxisEllipsoid(Constants.WGS84_EARTH_EQUATORIAL_RADIUS, Constants.WGS84_EARTH_FLATTENING, fixed);
        for (int k = 0; k <= duration; k++) {
            final AbsoluteDate date = start.shiftedBy(k);
            final PVCoordinates pv = orbit.getPVCoordinates(date, inertial), earthFixed = orbit.getPVCoordinates(date, fixed);
            final GeodeticPoint place = earth.transform(earthFixed.getPosition(), fixed, date);
            final Vector3D b =
                field.calculateField(place.getLatitude(), place.getLongitude(), place.getAltitude()).getFieldVector();
            final Vector3D vector = place.getNorth().scalarMultiply(b.getX()).add(place.getEast().scalarMultiply(b.getY()))
                .add(place.getNadir().scalarMultiply(b.getZ())).scalarMultiply(1e9);       // nT, of tesla north, east, down
            show("day", x[0] + k, pv.getPosition(), pv.getVelocity(), earthFixed.getPosition(), earthFixed.getVelocity(),
                 fixed.getStaticTransformTo(inertial, date).transformVector(vector));
        }
    }
}
