// Orekit's gravity field and orbit with the coefficients of data/egm96_deg70.gfc: for bench/peers.py.
//     OrekitPeer FOLDER gravity DEGREE | forces | forces-dark | orbit
import java.io.File;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.Locale;
import org.hipparchus.CalculusFieldElement;
import org.hipparchus.geometry.euclidean.threed.Rotation;
import org.hipparchus.geometry.euclidean.threed.RotationConvention;
import org.hipparchus.geometry.euclidean.threed.Vector3D;
import org.hipparchus.ode.nonstiff.DormandPrince853Integrator;
import org.orekit.attitudes.Attitude;
import org.orekit.bodies.AnalyticalSolarPositionProvider;
import org.orekit.bodies.OneAxisEllipsoid;
import org.orekit.data.DataContext;
import org.orekit.data.DirectoryCrawler;
import org.orekit.forces.ForceModel;
import org.orekit.forces.drag.DragForce;
import org.orekit.forces.drag.IsotropicDrag;
import org.orekit.forces.gravity.HolmesFeatherstoneAttractionModel;
import org.orekit.forces.gravity.NewtonianAttraction;
import org.orekit.forces.gravity.potential.GravityFieldFactory;
import org.orekit.forces.gravity.potential.ICGEMFormatReader;
import org.orekit.forces.gravity.potential.NormalizedSphericalHarmonicsProvider;
import org.orekit.forces.radiation.IsotropicRadiationSingleCoefficient;
import org.orekit.forces.radiation.KnockeRediffusedForceModel;
import org.orekit.forces.radiation.SolarRadiationPressure;
import org.orekit.frames.FieldTransform;
import org.orekit.frames.Frame;
import org.orekit.frames.FramesFactory;
import org.orekit.frames.StaticTransform;
import org.orekit.frames.Transform;
import org.orekit.frames.TransformProvider;
import org.orekit.models.earth.atmosphere.DTM2000;
import org.orekit.models.earth.atmosphere.DTM2000InputParameters;
import org.orekit.orbits.CartesianOrbit;
import org.orekit.orbits.OrbitType;
import org.orekit.propagation.SpacecraftState;
import org.orekit.propagation.numerical.NumericalPropagator;
import org.orekit.time.AbsoluteDate;
import org.orekit.time.DateComponents;
import org.orekit.time.FieldAbsoluteDate;
import org.orekit.time.OffsetModel;
import org.orekit.time.TimeScalesFactory;
import org.orekit.utils.AngularCoordinates;
import org.orekit.utils.Constants;
import org.orekit.utils.PVCoordinates;
import org.orekit.utils.TimeStampedPVCoordinates;

public class OrekitPeer {
    static final double R = 6.838e6;
    static double total = 0;

    static Vector3D place(int i) {
        final double a = 2 * Math.PI * ((i * 0.618034) % 1.0);
        final double b = 2 * Math.PI * ((i * 0.381966 * 0.5) % 0.5 - 0.25) * 0.98;
        return new Vector3D(R * (Math.cos(b) * Math.cos(a)), R * (Math.cos(b) * Math.sin(a)), R * Math.sin(b));
    }

    static Vector3D acceleration(HolmesFeatherstoneAttractionModel model, Vector3D r, double mu) {
        final double[] g = model.gradient(AbsoluteDate.J2000_EPOCH, r, mu);     // without the central part
        final double d = r.getNorm();
        final double c = -mu / (d * d * d);
        return new Vector3D(c * r.getX() + g[0], c * r.getY() + g[1], c * r.getZ() + g[2]);
    }

    public static void main(String[] args) {
        Locale.setDefault(Locale.ROOT);
        DataContext.getDefault().getDataProvidersManager().addProvider(new DirectoryCrawler(new File(args[0])));
        GravityFieldFactory.addPotentialCoefficientsReader(new ICGEMFormatReader("peer\\.gfc", true));
        final int degree = args[1].equals("gravity") ? Integer.parseInt(args[2]) : 20;
        final NormalizedSphericalHarmonicsProvider provider =
            GravityFieldFactory.getConstantNormalizedProvider(degree, degree, AbsoluteDate.J2000_EPOCH);
        final Frame frame = FramesFactory.getGCRF();        // an Earth that does not turn
        final HolmesFeatherstoneAttractionModel model = new HolmesFeatherstoneAttractionModel(frame, provider);
        if (args[1].equals("gravity")) {
            gravity(model, provider.getMu(), degree);
        } else if (args[1].startsWith("forces")) {
            forces(provider, args[1].equals("forces"));
        } else {
            orbit(model, provider.getMu(), frame);
        }
        if (total == 1e300) System.out.println(total);
    }

    static void gravity(HolmesFeatherstoneAttractionModel model, double mu, int degree) {
        final Vector3D[] places = new Vector3D[1000];
        for (int i = 1; i <= 1000; i++) places[i - 1] = place(i);
        final int calls = 400000 / degree;
        double best = 1e9;
        for (int repeat = 0; repeat < 25; repeat++) {       // the first ones warm the compiler
            final long start = System.nanoTime();
            for (int k = 1; k <= calls; k++) total += acceleration(model, places[k % 1000], mu).getX();
            best = Math.min(best, (System.nanoTime() - start) * 1e-9 / calls);
        }
        System.out.printf("seconds %.6e%n", best);
        for (int i = 0; i < 5; i++) {
            final Vector3D a = acceleration(model, places[i], mu);
            System.out.printf("value %.16e %.16e %.16e%n", a.getX(), a.getY(), a.getZ());
        }
    }

    // The Earth as gracecg's front-1 has it: about the z axis.
    static class Turning implements TransformProvider {
        static final double ANGLE = Math.toRadians(101.60748558), RATE = 7.292115e-5;
        final AbsoluteDate epoch;

        Turning(AbsoluteDate epoch) {
            this.epoch = epoch;
        }

        Rotation rotation(AbsoluteDate date) {
            return new Rotation(Vector3D.PLUS_K, ANGLE + RATE * date.durationFrom(epoch), RotationConvention.FRAME_TRANSFORM);
        }

        public Transform getTransform(AbsoluteDate date) {
            return new Transform(date, rotation(date), new Vector3D(0, 0, RATE));
        }

        public StaticTransform getStaticTransform(AbsoluteDate date) {
            return StaticTransform.of(date, rotation(date));
        }

        public <T extends CalculusFieldElement<T>> FieldTransform<T> getTransform(FieldAbsoluteDate<T> date) {
            throw new UnsupportedOperationException();
        }
    }

    // The flux and Kp of front-1.
    static class Weather implements DTM2000InputParameters {
        public AbsoluteDate getMinDate() { return AbsoluteDate.PAST_INFINITY; }
        public AbsoluteDate getMaxDate() { return AbsoluteDate.FUTURE_INFINITY; }
        public double getInstantFlux(AbsoluteDate date) { return 185.7; }
        public double getMeanFlux(AbsoluteDate date) { return 210.6; }
        public double getThreeHourlyKP(AbsoluteDate date) { return 2.7; }
        public double get24HoursKp(AbsoluteDate date) { return 3.0; }
    }

    // What a numerical propagator sums at a state: gravity, drag, sunlight, and, if wanted, the Earth's light. Areas are
    // those of gracecg's prism: of the front, of the mean over all directions, of the bottom.
    static void forces(NormalizedSphericalHarmonicsProvider provider, boolean earthlight) {
        TimeScalesFactory.addUTCTAIOffsetsLoader(
            () -> Collections.singletonList(new OffsetModel(new DateComponents(1988, 1, 1), 24)));
        final AbsoluteDate epoch = new AbsoluteDate(1989, 1, 2, 0, 0, 0.0, TimeScalesFactory.getUTC());
        final Frame inertial = FramesFactory.getEME2000();
        final Frame fixed = new Frame(inertial, new Turning(epoch), "Earth", false);
        final double radius = Constants.WGS84_EARTH_EQUATORIAL_RADIUS, mu = provider.getMu();
        final OneAxisEllipsoid earth = new OneAxisEllipsoid(radius, Constants.WGS84_EARTH_FLATTENING, fixed);
        final AnalyticalSolarPositionProvider sun = new AnalyticalSolarPositionProvider();
        final List<ForceModel> models = new ArrayList<>();
        models.add(new NewtonianAttraction(mu));
        models.add(new HolmesFeatherstoneAttractionModel(fixed, provider));
        models.add(new DragForce(new DTM2000(new Weather(), sun, earth), new IsotropicDrag(0.949, 2.0)));
        models.add(new SolarRadiationPressure(sun, earth, new IsotropicRadiationSingleCoefficient(4.02, 1.56)));
        if (earthlight) {
            models.add(new KnockeRediffusedForceModel(sun, new IsotropicRadiationSingleCoefficient(6.06, 1.5), radius,
                                                      Math.toRadians(10.5)));      // 1.6 % off the integral
        }
        double best = 1e9;
        for (int repeat = 0; repeat < 25; repeat++) {       // the first ones warm the compiler
            final int calls = 5000;
            final long start = System.nanoTime();
            for (int k = 1; k <= calls; k++) {
                final SpacecraftState state = state(k % 1000 + 1, epoch, inertial, mu);
                Vector3D sum = Vector3D.ZERO;
                for (ForceModel model : models) {
                    sum = sum.add(model.acceleration(state, model.getParameters(state.getDate())));
                }
                total += sum.getX();
            }
            best = Math.min(best, (System.nanoTime() - start) * 1e-9 / calls);
        }
        System.out.printf("seconds %.6e%n", best);
        final double[] sizes = new double[models.size()];
        for (int k = 1; k <= 1000; k++) {
            final SpacecraftState state = state(k, epoch, inertial, mu);
            final Vector3D[] a = new Vector3D[sizes.length];
            for (int j = 0; j < sizes.length; j++) {
                a[j] = models.get(j).acceleration(state, models.get(j).getParameters(state.getDate()));
                sizes[j] += a[j].getNorm() / 1000;
            }
            final Vector3D g = a[0].add(a[1]);
            if (k <= 5) System.out.printf("value %.16e %.16e %.16e%n", g.getX(), g.getY(), g.getZ());
        }
        final String[] names = {"centre", "harmonics", "drag", "sunlight", "earthlight"};
        for (int j = 2; j < sizes.length; j++) System.out.printf("size %s %.6e%n", names[j], sizes[j]);
    }

    static SpacecraftState state(int i, AbsoluteDate epoch, Frame inertial, double mu) {
        final double angle = 2 * Math.PI * i / 1000, speed = 7634, c = Math.cos(angle), s = Math.sin(angle);
        final AbsoluteDate date = epoch.shiftedBy(5.6 * i);
        final Vector3D position = new Vector3D(R * c, 0, R * s), velocity = new Vector3D(-speed * s, 0, speed * c);
        return new SpacecraftState(
            new CartesianOrbit(new TimeStampedPVCoordinates(date, position, velocity), inertial, mu),
            new Attitude(date, inertial, AngularCoordinates.IDENTITY)).withMass(420);
    }

    static void orbit(HolmesFeatherstoneAttractionModel model, double mu, Frame frame) {
        final double[] tolerances = {1e-7, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6};       // m; the first: reference
        for (double tolerance : tolerances) {
            double best = 1e9;
            Vector3D end = Vector3D.ZERO;
            for (int repeat = 0; repeat < 12; repeat++) {
                final double v = 1e-3 * tolerance;          // m/s; the last is of the mass, which stays
                final double[] absolute = {tolerance, tolerance, tolerance, v, v, v, 1};
                final NumericalPropagator propagator = new NumericalPropagator(
                    new DormandPrince853Integrator(1e-3, 600, absolute, new double[7]));
                propagator.setOrbitType(OrbitType.CARTESIAN);
                propagator.addForceModel(new NewtonianAttraction(mu));
                propagator.addForceModel(model);
                propagator.setInitialState(new SpacecraftState(new CartesianOrbit(
                    new PVCoordinates(new Vector3D(R, 0, 0), new Vector3D(0, 120, 7634)), frame, AbsoluteDate.J2000_EPOCH, mu)));
                final long start = System.nanoTime();
                end = propagator.propagate(AbsoluteDate.J2000_EPOCH.shiftedBy(86400.0)).getPosition();
                best = Math.min(best, (System.nanoTime() - start) * 1e-9);
            }
            System.out.printf("run %.6e %.6e %.16e %.16e %.16e%n", tolerance, best, end.getX(), end.getY(), end.getZ());
        }
    }
}
