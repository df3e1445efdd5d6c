!> The star catalogue: the built-in stars, the field of view, files good and corrupted.
module test_star_catalogue
    use vocabulary
    use gracecg_base_quaternion, only: rotation_matrix, normalised
    use gracecg_simulation_star_catalogue, only: star_catalogue_t, builtin_star_catalogue, read_star_catalogue
    implicit none
    private
    public :: collect_star_catalogue

    real(dp), parameter :: FIELD(2) = [22*DEGREE, 16*DEGREE]
    character(*), parameter :: FIXTURES = 'test/fixtures/star_catalogue/'

    !> Sine and cosine of glibc's vector library, which gfortran takes from version 16 on, are right to 4 units of the last
    !> place, those of one number at a time to half a unit; a direction is a product of two
    real(dp), parameter :: VECTORISED = 10*epsilon(1.0_dp)

contains

    subroutine collect_star_catalogue(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('builtin-stars', test_builtin), &
                    new_unittest('field-of-view-by-angles', test_field), &
                    new_unittest('reads-a-file', test_file), &
                    new_unittest('corrupted-files', test_corrupted)]
    end subroutine collect_star_catalogue

    !> 4616 unit vectors; the one nearest the pole is Polaris, J2000 02h31m49.09s, +89d15'50.8" (ESA
    !> SP-1200).
    subroutine test_builtin(error)
        type(error_type), allocatable, intent(out) :: error
        type(star_catalogue_t) :: catalogue, builtin, source
        real(dp) :: ra, dec, polaris(3)
        integer :: i
        type(error_t), allocatable :: failure

        catalogue = builtin_star_catalogue()
        if (unmet(error, size(catalogue%direction, 2), 4616)) return
        call check(error, maxval(abs(norm2(catalogue%direction, 1) - 1)) < VECTORISED)
        call check(error, minval(catalogue%magnitude) >= 1 .and. maxval(catalogue%magnitude) <= 6)
        i = maxloc(catalogue%direction(3, :), 1)
        ra = (2 + 31/60.0_dp + 49.09_dp/3600)*15*DEGREE
        dec = (89 + 15/60.0_dp + 50.8_dp/3600)*DEGREE
        polaris = [cos(dec)*cos(ra), cos(dec)*sin(ra), sin(dec)]
        call check(error, norm2(catalogue%direction(:, i) - polaris) < 0.1_dp*ARCSECOND)
        call check(error, catalogue%magnitude(i), 1.97_dp, thr=0.05_dp)
        builtin = builtin_star_catalogue()
        call read_star_catalogue('data/bright_stars.txt', source, failure)
        if (failed(error, failure)) return
        if (unmet(error, size(source%magnitude), size(builtin%magnitude))) return
        call check(error, all(abs(builtin%direction - source%direction) < VECTORISED) .and. &
                   all(builtin%magnitude == source%magnitude))
    end subroutine test_builtin

    !> Against the angles off the boresight, for random cameras; and the first few of them alone.
    subroutine test_field(error)
        type(error_type), allocatable, intent(out) :: error
        type(star_catalogue_t) :: catalogue
        type(random_stream_t) :: stream
        real(dp) :: camera(3, 3), v(3)
        logical, allocatable :: inside(:)
        integer, allocatable :: expected(:)
        integer :: indices(200), first(7), n, trial, i

        catalogue = builtin_star_catalogue()
        allocate (inside(size(catalogue%magnitude)))
        stream = new_stream(51, 0, 0, 0, 0)
        do trial = 1, 20
            camera = random_rotation(stream)
            do i = 1, size(inside)
                v = matmul(camera, catalogue%direction(:, i))
                inside(i) = abs(atan2(v(1), v(3))) <= FIELD(1)/2 .and. &
                    abs(atan2(v(2), v(3))) <= FIELD(2)/2
            end do
            expected = pack([(i, i=1, size(inside))], inside)
            call catalogue%visible_stars(camera, FIELD, indices, n)
            if (unmet(error, n, size(expected))) return
            call check(error, all(indices(:n) == expected) .and. all(indices(n + 1:) == 0))
            call catalogue%visible_stars(camera, FIELD, first, n)
            if (unmet(error, n == min(7, size(expected)) .and. all(first(:n) == expected(:n)))) return
        end do
    end subroutine test_field

    function random_rotation(stream) result(m)
        type(random_stream_t), intent(inout) :: stream
        real(dp) :: m(3, 3)

        real(dp) :: q(4)

        call stream%normals(q)
        m = rotation_matrix(normalised(q))
    end function random_rotation

    subroutine test_file(error)
        type(error_type), allocatable, intent(out) :: error
        type(star_catalogue_t) :: catalogue
        type(error_t), allocatable :: failure

        call read_star_catalogue(FIXTURES//'three-stars.txt', catalogue, failure)
        if (failed(error, failure)) return
        if (unmet(error, size(catalogue%direction, 2), 2)) return
        call check(error, catalogue%magnitude(1) == 2.83_dp .and. catalogue%magnitude(2) == 1.97_dp)
        call check(error, catalogue%direction(3, 2), sin(89.2641095_dp*DEGREE))
    end subroutine test_file

    subroutine test_corrupted(error)
        type(error_type), allocatable, intent(out) :: error

        call expect_failure('no-such-file', 'no such file')
        call expect_failure('corrupted-column-missing', 'missing.txt:2: has 11 columns')
        call expect_failure('corrupted-column-extra', 'extra.txt:2: has 13 columns')
        call expect_failure('corrupted-truncated', 'truncated.txt:3: has 4 columns')
        call expect_failure('corrupted-right-ascension', ':3: right ascension')
        call expect_failure('corrupted-right-ascension-range', ':3: right ascension')
        call expect_failure('corrupted-declination', ':3: declination')
        call expect_failure('corrupted-declination-range', ':3: declination')
        call expect_failure('corrupted-magnitude', ':3: magnitude')
        call expect_failure('corrupted-pass', ':3: passA')
        call expect_failure('corrupted-proper-motion', ':4: column 6: "1.2.3" is not a finite number')
        call expect_failure('corrupted-number', ':3: column 2: "4-4" is not a finite number')
        call expect_failure('corrupted-no-star', 'no star with passA = 1')

    contains

        subroutine expect_failure(name, words)
            character(*), intent(in) :: name, words
            type(star_catalogue_t) :: catalogue
            type(error_t), allocatable :: failure

            call read_star_catalogue(FIXTURES//name//'.txt', catalogue, failure)
            call check_fails(error, failure, words)
        end subroutine expect_failure
    end subroutine test_corrupted
end module test_star_catalogue
