!> The star camera: CSR-TM-00-01 section 3.3.
!>
!> Two heads look 45 deg off the zenith (-z of the body) to both sides in the body's y-z plane. The
!> elevation of a boresight is counted from +y over the zenith to -y: head 1 at 45 deg looks to +y
!> (starboard when flying along +x with z down), head 2 at 135 deg to -y (port). Camera axes: z the
!> boresight, x the body's x, y = z cross x.
!>
!> The report does not say along which camera axis the field of view is 22 deg wide; here it is x.
!> Stars are matched with the catalogue without error, and aberration, proper motion and parallax
!> are left out, as in the report.
module gracecg_simulation_star_camera
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: PI, DEGREE, ARCSECOND
    use gracecg_base_error, only: error_t, fail, fail_out_of_range, add_context
    use gracecg_base_text, only: integer_text
    use gracecg_base_vectors, only: cross, unit, identity, determinant_3x3
    use gracecg_base_quaternion, only: quaternion_product, quaternion_from_axis_angle, rotation_matrix
    use gracecg_base_random, only: random_stream_t
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_simulation_star_catalogue, only: star_catalogue_t
    use gracecg_simulation_quest, only: quest
    implicit none
    private
    public :: star_camera_t, star_frame_t, STAR_SELECTIONS

    !> Which of the stars in the field are used: the first of the catalogue, as in the report, or the best
    character(8), parameter :: STAR_SELECTIONS(2) = [character(8) :: 'first', 'best']

    !> Performance of the star camera. The values here are those of CSR-TM-00-01 section 5.2.
    type :: star_camera_t
        real(dp) :: elevation(HEADS) = [45*DEGREE, 135*DEGREE]
        !! Of the boresights, from +y over -z in the body's y-z plane, rad
        real(dp) :: field_of_view(2) = [22*DEGREE, 16*DEGREE]
        !! Full angles along camera x and y, rad
        integer :: star_count = 20
        !! Greatest number of stars in a frame
        character(8) :: selection = 'first'     !! One of STAR_SELECTIONS
        integer :: minimum_stars = 2
        !! Fewest stars that make an attitude
        real(dp) :: sampling_interval = 0.5_dp      !! Between frames, s
        real(dp) :: catalogue_noise = 1*ARCSECOND
        !! Error of the catalogue's directions, standard deviation along each axis across, rad
        real(dp) :: measurement_noise = 3*ARCSECOND
        !! Error of the measured directions, likewise, rad
    contains
        procedure :: mounting   !! Rotation from the body to a head
        procedure :: noise      !! Standard deviation of an observed direction
        procedure :: see        !! The stars in a head's frame
        procedure :: stars_in_field     !! How many stars of a catalogue a head has before it
        procedure :: mean_stars_in_field    !! The same on average over all attitudes
        procedure, private :: check_settings
    end type star_camera_t

    !> The stars of one frame without noise: what is the same in every run of a Monte Carlo.
    type :: star_frame_t
        real(dp), allocatable :: reference(:, :)
        !! Catalogue directions, J2000; (3, stars)
        real(dp), allocatable :: line_of_sight(:, :)
        !! True directions, camera frame; (3, stars)
        real(dp), allocatable :: across_1(:, :), across_2(:, :)
        !! Axes across each line of sight, multiplied by the noise, camera frame, rad; (3, stars)
        real(dp), allocatable :: relative_deviation(:)
        !! In units of the noise: 1, all stars weigh the same; (stars)
        real(dp) :: noise = 0
        !! Standard deviation of a direction along each axis across it, rad
    contains
        procedure :: measure    !! Noisy directions of the stars
        procedure :: draw       !! A noisy attitude
    end type star_frame_t

contains

    !> ROT1 and ROT2 of CSR-TM-00-01 section 3.3.2: the rotation from the body to a camera frame, a
    !> turn about x by minus the boresight's angle from the body's z axis.
    pure function mounting(self, head) result(q)
        class(star_camera_t), intent(in) :: self
        integer, intent(in) :: head     !! 1 or 2
        real(dp) :: q(4)                !! Body to camera frame, scalar last

        q = quaternion_from_axis_angle([1.0_dp, 0.0_dp, 0.0_dp], -(PI/2 + self%elevation(head)))
    end function mounting

    !> Noise of a star's direction along each axis across it, of catalogue and measurement, rad.
    pure real(dp) function noise(self)
        class(star_camera_t), intent(in) :: self

        noise = hypot(self%catalogue_noise, self%measurement_noise)
    end function noise

    !> The stars that a head sees, in its axes (3-11). Fails when a setting is not in its range, the
    !> attitude is not a unit quaternion, or there are too few stars.
    subroutine see(self, catalogue, attitude, head, frame, error)
        class(star_camera_t), intent(in) :: self
        type(star_catalogue_t), intent(in) :: catalogue
        real(dp), intent(in) :: attitude(4)     !! True attitude, inertial (J2000) to body
        integer, intent(in) :: head             !! 1 or 2
        type(star_frame_t), intent(out) :: frame
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: camera(3, 3)
        integer :: indices(merge(size(catalogue%direction, 2), self%star_count, self%selection == 'best')), n, i

        call self%check_settings(attitude, head, error)
        if (allocated(error)) return
        camera = rotation_matrix(quaternion_product(self%mounting(head), attitude))
        call catalogue%visible_stars(camera, self%field_of_view, indices, n)
        if (n < self%minimum_stars) then
            call fail(error, 'the star camera sees '//integer_text(n)//' stars, at least '//integer_text(self%minimum_stars)// &
                      ' are needed: widen the field of view or use a richer catalogue')
            return
        end if
        if (n > self%star_count) call choose_best(matmul(camera, catalogue%direction(:, indices(:n))), &
                                                  self%star_count, indices(:n), n)
        frame%noise = self%noise()
        frame%reference = catalogue%direction(:, indices(:n))
        frame%line_of_sight = matmul(camera, frame%reference)
        allocate (frame%across_1(3, n), frame%across_2(3, n))
        allocate (frame%relative_deviation(n), source=1.0_dp)
        do i = 1, n
            call across(frame%line_of_sight(:, i), frame%across_1(:, i), frame%across_2(:, i))
        end do
        frame%across_1 = frame%noise*frame%across_1
        frame%across_2 = frame%noise*frame%across_2
    end subroutine see

    !> The number of a catalogue's stars in the field of a head.
    pure integer function stars_in_field(self, catalogue, attitude, head) result(n)
        class(star_camera_t), intent(in) :: self
        type(star_catalogue_t), intent(in) :: catalogue
        real(dp), intent(in) :: attitude(4)     !! Inertial (J2000) to body, unit
        integer, intent(in) :: head             !! 1 or 2

        integer :: indices(size(catalogue%direction, 2))

        call catalogue%visible_stars(rotation_matrix(quaternion_product(self%mounting(head), attitude)), &
                                     self%field_of_view, indices, n)
    end function stars_in_field

    !> The mean number of stars in the field over all attitudes: stars times the field's part of the sphere, whose
    !> solid angle is 4 asin[sin(a/2) sin(b/2)].
    pure real(dp) function mean_stars_in_field(self, catalogue) result(mean)
        class(star_camera_t), intent(in) :: self
        type(star_catalogue_t), intent(in) :: catalogue

        mean = size(catalogue%direction, 2)*asin(product(sin(self%field_of_view/2)))/PI
    end function mean_stars_in_field

    !> The best stars of a frame: with the least trace of QUEST's covariance (3-21), stars of equal noise. From the
    !> first ones on, the exchange of a star in use for one that is not which lowers the trace most is made until
    !> none does: never worse than the first, and a minimum against single exchanges.
    pure subroutine choose_best(line_of_sight, most, indices, n)
        real(dp), intent(in) :: line_of_sight(:, :)     !! Unit vectors, camera frame; (3, stars)
        integer, intent(in) :: most                     !! Stars to use, fewer than there are
        integer, intent(inout) :: indices(:)            !! Of the stars; then those in use come first
        integer, intent(out) :: n                       !! Number in use

        real(dp) :: information(3, 3), line(3, size(indices)), trace, least, found
        integer :: i, j, best(2)

        line = line_of_sight
        n = most
        information = 0
        do i = 1, n
            information = information + across_projection(line(:, i))
        end do
        trace = trace_of_inverse(information)
        do
            least = trace*(1 - 1e-12_dp)        ! above rounding
            best = 0
            do i = 1, n
                do j = n + 1, size(indices)
                    found = trace_of_inverse(information - across_projection(line(:, i)) + across_projection(line(:, j)))
                    if (.not. found < least) cycle
                    least = found
                    best = [i, j]
                end do
            end do
            if (best(1) == 0) return
            information = information - across_projection(line(:, best(1))) + across_projection(line(:, best(2)))
            trace = least
            line(:, best) = line(:, best([2, 1]))
            indices(best) = indices(best([2, 1]))
        end do
    end subroutine choose_best

    !> I - W W^T: what one star says of the three angles.
    pure function across_projection(w) result(projection)
        real(dp), intent(in) :: w(3)
        real(dp) :: projection(3, 3)

        projection = identity(3) - spread(w, 2, 3)*spread(w, 1, 3)
    end function across_projection

    !> Of a symmetric matrix; huge if it is singular.
    pure real(dp) function trace_of_inverse(m) result(trace)
        real(dp), intent(in) :: m(3, 3)

        real(dp) :: determinant

        determinant = determinant_3x3(m)
        trace = huge(trace)
        if (determinant > 0) trace = (m(1, 1)*m(2, 2) - m(1, 2)**2 + m(2, 2)*m(3, 3) - m(2, 3)**2 + &
                                      m(3, 3)*m(1, 1) - m(1, 3)**2)/determinant
    end function trace_of_inverse

    !> Two axes that make a right-handed frame with a line of sight.
    pure subroutine across(line, axis_1, axis_2)
        real(dp), intent(in) :: line(3)
        real(dp), intent(out) :: axis_1(3), axis_2(3)

        real(dp) :: helper(3)

        helper = 0
        helper(minloc(abs(line), 1)) = 1
        axis_1 = unit(cross(helper, line))
        axis_2 = cross(line, axis_1)
    end subroutine across

    !> Noisy directions of the frame's stars: Gaussian noise across every line of sight.
    subroutine measure(self, stream, observed)
        class(star_frame_t), intent(in) :: self
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(out) :: observed(:, :)     !! Unit vectors, camera frame; (3, stars)

        real(dp) :: draws(2*size(self%reference, 2)), line(3)
        integer :: i

        call stream%normals(draws)
        do i = 1, size(observed, 2)
            line = self%line_of_sight(:, i) + draws(2*i - 1)*self%across_1(:, i) + draws(2*i)*self%across_2(:, i)
            observed(:, i) = line/norm2(line)
        end do
    end subroutine measure

    !> One noisy attitude from a frame of stars: noisy directions, then QUEST. Fails when the stars
    !> are collinear.
    subroutine draw(self, stream, q_observed, covariance, error)
        class(star_frame_t), intent(in) :: self
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(out) :: q_observed(4)      !! Inertial (J2000) to camera frame, q(4) >= 0
        real(dp), intent(out) :: covariance(3, 3)
        !! Of half the angles of the error, camera frame, rad^2: CSR-TM-00-01 eq. (3-21)
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: observed(3, size(self%reference, 2)), loss

        call self%measure(stream, observed)
        call quest(observed, self%reference, self%relative_deviation, q_observed, covariance, &
                   loss, error)
        covariance = self%noise**2*covariance
    end subroutine draw

    subroutine check_settings(self, attitude, head, error)
        class(star_camera_t), intent(in) :: self
        real(dp), intent(in) :: attitude(4)
        integer, intent(in) :: head
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: NORM_TOLERANCE = 1e-6_dp     ! far beyond what an integration loses, far below a wrong quaternion

        if (head < 1 .or. head > HEADS) then
            call fail_out_of_range(error, 'head', real(head, dp), 1.0_dp, real(HEADS, dp))
        else if (.not. abs(norm2(attitude) - 1) <= NORM_TOLERANCE) then
            call fail_out_of_range(error, 'norm of the attitude quaternion', norm2(attitude), &
                                   1 - NORM_TOLERANCE, 1 + NORM_TOLERANCE)
        else if (.not. all(self%field_of_view > 0 .and. self%field_of_view < PI)) then
            call fail(error, 'both angles of the field of view must lie between 0 and 180 deg')
        else if (.not. all(ieee_is_finite(self%elevation))) then
            call fail(error, 'the elevation of a head is not a finite number')
        else if (self%minimum_stars < 2 .or. self%star_count < self%minimum_stars) then
            call fail(error, 'the number of stars in a frame must be at least the minimum, and '// &
                      'that at least 2')
        else if (.not. all([self%catalogue_noise, self%measurement_noise] >= 0) .or. &
                 .not. ieee_is_finite(self%noise())) then
            call fail(error, 'catalogue and measurement noise must be finite and not negative')
        end if
        call add_context(error, 'star camera')
    end subroutine check_settings
end module gracecg_simulation_star_camera
